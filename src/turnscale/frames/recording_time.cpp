// SPDX-License-Identifier: MIT
#include "turnscale/frames/recording_time.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/frames/clip_names.h"
#include "turnscale/frames/clip_overlap.h"

namespace turnscale {
namespace {

// Both ends of a pause are known to the second, rounded down.
constexpr double kResolution = 1.5;  // s
// Creation times that differ by no more are of the same moment.
constexpr double kSameMoment = 1;  // s
// Clips that overlap by a larger share of the shorter one are of two cameras.
constexpr double kLargestShare = 0.5;
// A path across a longer one would be a guess.
constexpr double kLongestPause = 600;  // s

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Year to second as a text has them, and the separators before each; 0 where there is none.
struct NamedTime {
  std::array<int, 6> values{};
  std::array<char, 6> separators{};
  size_t size = 0;  // of the text
};

// Reads the six numbers at the beginning of the text.
std::optional<NamedTime> NumbersAt(std::string_view text, size_t year_digits) {
  constexpr std::string_view kSeparators = "_-. :T";
  NamedTime time;
  size_t& at = time.size;
  for (size_t i = 0; i < time.values.size(); ++i) {
    if (i > 0 && at < text.size() && kSeparators.find(text[at]) != std::string_view::npos)
      time.separators[i] = text[at++];
    for (size_t k = 0; k < (i == 0 ? year_digits : 2); ++k, ++at) {
      if (at >= text.size() || !IsDigit(text[at])) return std::nullopt;
      time.values[i] = 10 * time.values[i] + (text[at] - '0');
    }
  }
  return time;
}

// Since 1970; nothing if there is no such time in this century.
std::optional<double> SecondsOf(const std::array<int, 6>& values) {
  const auto [year, month, day, hour, minute, second] = values;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (year < 2000 || year > 2099 || !date.ok() || hour > 23 || minute > 59 || second > 59) return std::nullopt;
  const auto days = std::chrono::sys_days(date).time_since_epoch().count();
  return 86400.0 * static_cast<double>(days) + 3600.0 * hour + 60.0 * minute + second;
}

std::optional<double> TimeAt(std::string_view text) {
  const std::optional<NamedTime> time = NumbersAt(text, 4);
  return time ? SecondsOf(time->values) : std::nullopt;
}

std::optional<double> ShortTimeAt(std::string_view text) {
  std::optional<NamedTime> time = NumbersAt(text, 2);
  if (!time || (time->size < text.size() && IsDigit(text[time->size]))) return std::nullopt;
  const std::array<char, 6>& separators = time->separators;
  const bool date_is_apart = separators[3] != 0;
  if (!date_is_apart || separators[1] != separators[2] || separators[4] != separators[5]) return std::nullopt;
  time->values[0] += 2000;
  return SecondsOf(time->values);
}

// What `time_at` finds first in the name, at the beginning of a number.
std::optional<double> FirstTime(std::string_view name, std::optional<double> (*time_at)(std::string_view)) {
  for (size_t i = 0; i < name.size(); ++i) {
    if (i > 0 && IsDigit(name[i - 1])) continue;
    if (const std::optional<double> time = time_at(name.substr(i))) return time;
  }
  return std::nullopt;
}

std::optional<Chapter> ChapterOf(const std::filesystem::path& clip) { return ChapterInName(clip.stem().string()); }

bool AreOfOneRecording(const std::optional<Chapter>& a, const std::optional<Chapter>& b) {
  return a && b && a->recording == b->recording;
}

}  // namespace

std::optional<double> TimeInName(std::string_view name) { return FirstTime(name, TimeAt); }

std::optional<double> ShortTimeInName(std::string_view name) { return FirstTime(name, ShortTimeAt); }

std::string RecorderTimeText(double seconds) {
  const std::chrono::sys_seconds time{std::chrono::seconds(static_cast<int64_t>(std::floor(seconds)))};
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date{day};
  const std::chrono::hh_mm_ss hours{time - day};
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), hours.hours().count(),
                     hours.minutes().count(), hours.seconds().count());
}

RecordingTimes::RecordingTimes(const std::vector<std::filesystem::path>& clips, const std::vector<VideoHeader>& headers)
    : clips_(clips) {
  std::vector<double> named;
  std::vector<double> named_shortly;
  std::vector<double> created;
  std::string unnamed;  // the first clip without a time in its name
  for (size_t i = 0; i < clips.size(); ++i) {
    durations_.push_back(headers[i].duration);
    const auto time = TimeInName(clips[i].stem().string());
    const auto short_time = ShortTimeInName(clips[i].stem().string());
    if (time) named.push_back(*time);
    if (short_time) named_shortly.push_back(*short_time);
    if (!time && !short_time && unnamed.empty()) unnamed = clips[i].filename().string();
    if (headers[i].created) created.push_back(*headers[i].created);
  }
  const bool some_are_named = !named.empty();
  by_name_ = !clips.empty();
  starts_ = std::move(named);
  if (starts_.size() == clips.size()) return;
  starts_ = std::move(named_shortly);
  const bool all_are_named_shortly = starts_.size() == clips.size();
  const std::optional<size_t> apart = all_are_named_shortly ? FirstApart() : std::nullopt;
  if (all_are_named_shortly && !apart) return;
  if (created.size() != clips.size()) {
    constexpr auto kNotUsed = "the times in the names of the clips are not used, as ";
    if (apart)
      why_not_by_names_ = fmt::format("{}{} {} by them: are the clips of one drive and one camera, in their order?",
                                      kNotUsed, clips[*apart + 1].filename().string(), PlaceAfter(*apart));
    else if (some_are_named && !unnamed.empty())
      why_not_by_names_ = fmt::format("{}{} has none", kNotUsed, unnamed);
  }
  by_name_ = false;
  starts_.clear();
  if (created.size() != clips.size()) return;
  created_ = std::move(created);
  PlaceCoinciding();
}

// Whether the clip cannot begin at its creation time, as it is that of the clip before.
bool RecordingTimes::Coincides(size_t clip) const {
  if (created_.empty()) return false;
  const double between = created_[clip] - created_[clip - 1];
  return std::abs(between) <= kSameMoment && durations_[clip - 1] - between > kResolution;
}

void RecordingTimes::PlaceCoinciding() {
  starts_ = created_;
  for (size_t i = 1; i < starts_.size(); ++i) {
    if (!Coincides(i)) continue;
    starts_[i] = starts_[i - 1] + durations_[i - 1];
    // The end of a short clip is that moment, too.
    const bool guessed =
        !AreOfOneRecording(ChapterOf(clips_[i - 1]), ChapterOf(clips_[i])) && durations_[i] > kResolution;
    if (guessed && !guessed_) guessed_ = i;
  }
}

double RecordingTimes::PauseAfter(size_t clip, double duration) const {
  const double between = starts_[clip + 1] - starts_[clip];
  const double pause = between - duration;
  // Some recorders write the creation time when they close the file.
  const bool by_ends = !by_name_ && !Coincides(clip + 1) && std::abs(between - durations_[clip + 1]) <= kResolution;
  return by_ends ? 0.0 : pause;
}

void RecordingTimes::CheckChapters() const {
  for (size_t i = 1; i < clips_.size(); ++i) {
    if (!starts_.empty() && !Coincides(i)) continue;
    const std::optional<Chapter> before = ChapterOf(clips_[i - 1]);
    const std::optional<Chapter> chapter = ChapterOf(clips_[i]);
    if (!AreOfOneRecording(before, chapter) || chapter->number == before->number + 1) continue;
    throw InputError(fmt::format(
        "{}: is chapter {} of its recording, but follows chapter {} ({}); give chapters that follow one another, in "
        "their order",
        clips_[i].string(), chapter->number, before->number, clips_[i - 1].filename().string()));
  }
}

bool RecordingTimes::OverlapsTooFar(size_t clip) const {
  const double overlap = -PauseAfter(clip, durations_[clip]);
  const double shorter = std::min(durations_[clip], durations_[clip + 1]);
  return overlap > kResolution && (overlap > kResolution + kLongestOverlap || overlap > kLargestShare * shorter);
}

// The first clip that the next one does not follow.
std::optional<size_t> RecordingTimes::FirstApart() const {
  for (size_t i = 0; i + 1 < starts_.size(); ++i)
    if (OverlapsTooFar(i) || PauseAfter(i, durations_[i]) > kLongestPause) return i;
  return std::nullopt;
}

// When the next clip begins, which does not follow this one.
std::string RecordingTimes::PlaceAfter(size_t clip) const {
  const double pause = PauseAfter(clip, durations_[clip]);
  const std::string before = clips_[clip].filename().string();
  return pause > 0 ? fmt::format("begins {:.0f} minutes after {} ends", pause / 60, before)
                   : fmt::format("begins {:.1f} s before {} ends", -pause, before);
}

void RecordingTimes::CheckContinuity() const {
  CheckChapters();
  const char* times = by_name_ ? "in their names" : "at which the files were made (creation_time)";
  const std::optional<size_t> apart = FirstApart();
  if (!apart) return;
  throw InputError(fmt::format("{}: {}, by the times {}{}", clips_[*apart + 1].string(), PlaceAfter(*apart), times,
                               OverlapsTooFar(*apart)
                                   ? "; give the clips of one camera (front or rear), in the order of time"
                                   : ": another drive; name the clips of one drive instead"));
}

double RecordingTimes::GapAfter(size_t clip, double duration) const {
  if (clip + 1 >= starts_.size()) return 0;
  const double pause = PauseAfter(clip, duration);
  return pause > kResolution ? pause : 0;
}

double RecordingTimes::GapAtJump(size_t clip, double duration) const {
  // A shorter one is hardly seen.
  constexpr double kLeast = 0.5;  // s
  if (clip + 1 >= starts_.size() || Coincides(clip + 1)) return 0;
  const double between = starts_[clip + 1] - starts_[clip];
  const double by_starts = between - duration;
  if (by_name_) return by_starts <= -kSameMoment ? 0 : std::max(by_starts, kLeast);
  // Creation times are those of the beginning of the clips or of their end: the shorter gap is the likelier one.
  double gap = kLongestPause;
  for (const double pause : {by_starts, between - durations_[clip + 1]})
    if (pause >= kLeast) gap = std::min(gap, pause);
  return gap < kLongestPause ? gap : kLeast;
}

double RecordingTimes::LikelyGapAfter(size_t clip, double duration) const {
  // By rounding alone, a pause is below a second, and rarely this long.
  constexpr double kLeast = 0.9;  // s
  if (!by_name_ || clip + 1 >= starts_.size()) return 0;
  const double pause = PauseAfter(clip, duration);
  return pause >= kLeast && pause <= kResolution ? pause : 0;
}

double RecordingTimes::OverlapAfter(size_t clip, double duration) const {
  if (clip + 1 >= starts_.size()) return 0;
  const double pause = PauseAfter(clip, duration);
  return pause < -kResolution ? -pause : 0;
}

}  // namespace turnscale
