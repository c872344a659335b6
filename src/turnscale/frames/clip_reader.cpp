// SPDX-License-Identifier: MIT
#include "turnscale/frames/clip_reader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

std::string NameOf(const std::filesystem::path& path) { return path.filename().string(); }

// Of the whole clip. A header's duration may be what the file still holds; its count is not.
double Length(const VideoHeader& header) {
  return header.counted && header.rate > 0 ? header.frames / header.rate : header.duration;
}

constexpr double kSmallShare = 0.01;

// Whether a clip may well be whole without so many frames: some headers only estimate.
bool AreFew(double missing, const VideoHeader& header) {
  constexpr int kFewFrames = 2;
  return missing <= kFewFrames || missing <= kSmallShare * header.frames;
}

// Why the clip ends before it should; empty if it does not. `end`: of the last frame after the beginning of the clip,
// if the stamps tell; frames that are missing before it do not end the clip.
std::string EndsTooEarly(const VideoHeader& header, int frames, double seconds, const std::optional<double>& end) {
  constexpr double kFewSeconds = 1;
  if (header.counted) {
    if (AreFew(header.frames - frames, header)) return {};
    if (end && AreFew((Length(header) - *end) * header.rate, header)) return {};
    return fmt::format("the video ends after {} of {} frames", frames, header.frames);
  }
  const double missing = header.duration - seconds;
  if (missing <= kFewSeconds || missing <= kSmallShare * header.duration) return {};
  return fmt::format("the video ends after {:.1f} of {:.1f} s", seconds, header.duration);
}

// The notice where a clip that does not end early has fewer frames than its header says; empty if it has them.
std::string LacksFrames(const std::string& name, const VideoHeader& header, int frames, bool by_rate) {
  if (!header.counted || AreFew(header.frames - frames, header)) return {};
  return fmt::format("{}: {} of {} frames are missing or cannot be decoded{}", name, header.frames - frames,
                     header.frames, by_rate ? "; --fps does not allow for that: leave it out" : "");
}

// The notice where a file holds more than one video; empty where none does.
std::string SeveralTracks(const std::vector<std::filesystem::path>& clips, const std::vector<VideoHeader>& headers) {
  const auto several = std::ranges::find_if(headers, [](const VideoHeader& header) { return header.tracks > 1; });
  if (several == headers.end()) return {};
  return fmt::format("{}: has {} video tracks; the first, {}x{}, is used", NameOf(clips[several - headers.begin()]),
                     several->tracks, several->size.width, several->size.height);
}

// The notice where --fps differs from the video's own rate; empty if it does not. The header's rate is a mean, which
// missing frames change.
std::string OtherRate(const std::optional<double>& fps, const VideoHeader& header) {
  constexpr double kSame = 0.1;
  if (!fps || header.rate <= 0 || std::abs(*fps / header.rate - 1) < kSame) return {};
  return fmt::format(
      "--fps {:g} replaces the video's own times, of {:.4g} frames/s: leave it out unless those are wrong", *fps,
      header.rate);
}

// The notice where a clip says another shape of its pixels than the first one, whose is used; empty if it does not.
std::string OtherPixels(const std::string& name, double aspect, const std::string& first_name, double first_aspect) {
  constexpr double kSame = 0.01;
  if (std::abs(aspect / first_aspect - 1) < kSame) return {};
  return fmt::format(
      "{}: its pixels are {:.3g} times as wide as high, those of {} {:.3g} times, which is used for both", name, aspect,
      first_name, first_aspect);
}

}  // namespace

ClipReader::ClipReader(const std::vector<std::filesystem::path>& clips, const ClipOptions& options)
    : options_(options) {
  ReadHeaders(clips);
  for (size_t i = 1; i < clips_.size(); ++i) {
    const cv::Size size = headers_[i].size;
    const cv::Size first = headers_.front().size;
    if (size == first) continue;
    throw InputError(fmt::format("{}: is {}x{} pixels, but {} is {}x{}; give the clips of one camera",
                                 clips_[i].string(), size.width, size.height, NameOf(clips_.front()), first.width,
                                 first.height));
  }
  const bool known =
      std::all_of(headers_.begin(), headers_.end(), [](const auto& header) { return header.frames > 0; });
  for (const VideoHeader& header : headers_) count_ += known ? header.frames : 0;
  if (recorded_) recorded_->CheckContinuity();
}

void ClipReader::ReadHeaders(const std::vector<std::filesystem::path>& clips) {
  struct Failure {
    std::filesystem::path path;
    size_t clip;  // that follows, of those that can be decoded
    std::string problem;
  };
  std::vector<Failure> failures;
  for (const auto& clip : clips) {
    try {
      auto video = std::make_unique<VideoFile>(clip);
      headers_.push_back(video->header());
      // Opened once more when its turn comes: a decoder needs memory.
      if (!video_) video_ = std::move(video);
    } catch (const UnreadableVideo& error) {
      failures.push_back({clip, clips_.size(), error.what()});
      continue;
    }
    clips_.push_back(clip);
  }
  if (!failures.empty() && clips_.empty()) throw InputError(failures.front().problem);
  if (options_.timed) recorded_.emplace(clips_, headers_);
  for (const Failure& failure : failures) {
    left_out_.push_back(failure.problem + "; the clip is left out");
    if (failure.clip == 0)
      left_out_.back() += fmt::format(": the beginning of the drive is missing, and times count from {}",
                                      clips_.front().filename().string());
    const bool between = failure.clip > 0 && failure.clip < clips_.size();
    left_out_before_.emplace(failure.clip, failure.path);
    if (between && !(recorded_ && recorded_->AreInNames()))
      throw InputError(
          failure.problem +
          "; the gap that it leaves is of unknown length: process the clips before and after it separately");
    // Each image has its time by its number.
    if (!options_.timed) throw InputError(failure.problem + "; leave out the clip, and its times (--timestamps)");
  }
  if (options_.in_any_order && recorded_ && !recorded_->AreKnown()) {
    const bool one_folder = clips_.back().parent_path() == clips_.front().parent_path();
    throw InputError(fmt::format(
        "{}: {} than {}, and their recording times are not known; name the clips of one drive in their order",
        clips_.back().string(), one_folder ? "is of another recording" : "lies in another folder",
        clips_.front().string()));
  }
}

// Why the drive lacks images before a clip, or at its end; empty if no clip is left out there.
std::string ClipReader::LackBefore(size_t clip) const {
  const auto left_out = left_out_before_.find(clip);
  if (left_out == left_out_before_.end()) return {};
  const char* part = clip == 0 ? "the beginning" : clip == clips_.size() ? "the end" : "a part";
  return fmt::format("{}: cannot be decoded: {} of the drive is missing", NameOf(left_out->second), part);
}

std::string ClipReader::BeginsLate() const { return LackBefore(0); }

bool ClipReader::HasTimes() const {
  return options_.fps ||
         std::all_of(headers_.begin(), headers_.end(), [](const auto& header) { return header.rate > 0; });
}

int ClipReader::CountBetween(double start, const std::optional<double>& end) const {
  if (count_ == 0) return 0;
  double begin = 0;  // of the clip
  double frames = 0;
  for (size_t i = 0; i < headers_.size(); ++i) {
    const double rate = options_.fps.value_or(headers_[i].rate);
    const double seconds = headers_[i].frames / rate;
    const double first = std::clamp(start - begin, 0.0, seconds);
    const double last = end ? std::clamp(*end - begin, first, seconds) : seconds;
    frames += (last - first) * rate;
    begin += seconds + (recorded_ ? recorded_->GapAfter(i, seconds) : 0);
  }
  return static_cast<int>(std::lround(frames));
}

void ClipReader::Open() {
  open_ = true;
  if (!video_) video_ = std::make_unique<VideoFile>(clips_[clip_]);
  const VideoHeader& header = headers_[clip_];
  AddSentence(notice_, OtherPixels(NameOf(clips_[clip_]), header.pixel_aspect, NameOf(clips_.front()), pixel_aspect()));
  clock_ = VideoClock(options_.fps.value_or(header.rate), header.tick);
  frames_ = 0;
  latest_stamp_.reset();
  if (options_.timed && !options_.fps && begin_ < options_.start) PassOverStart();
}

// Without decoding, where the file tells the time of every frame: up to the last key frame that is not after the start,
// nor so late that the next clip may repeat what follows.
void ClipReader::PassOverStart() {
  const std::vector<FrameStamp> stamps = VideoFile::ReadStamps(clips_[clip_]);
  if (stamps.empty()) return;
  const bool is_last = clip_ + 1 == clips_.size();
  const double end = begin_ + stamps.back().seconds - stamps.front().seconds;
  const double limit = is_last ? options_.start : std::min(options_.start, end - kLongestOverlap);
  size_t key = 0;
  VideoClock clock = clock_;
  VideoClock before_key = clock_;
  for (size_t i = 0; i < stamps.size(); ++i) {
    const VideoClock before = clock;
    const double time = begin_ + clock.Next(stamps[i].seconds);
    if (time > limit) break;
    latest_ = time;
    if (!stamps[i].key) continue;
    key = i;
    before_key = before;
  }
  if (key == 0) return;
  clock_ = before_key;
  frames_ = static_cast<int>(key);
  passed_ += key;
  video_->StartAt(stamps[key].seconds);
}

std::optional<double> ClipReader::TimeNext() {
  if (!options_.timed) return std::nullopt;
  const double before = clock_.time();
  const double time = clock_.Next(options_.fps ? std::nullopt : video_->Stamp());
  const double gap = frames_ > 0 ? time - before - clock_.Interval() : 0;
  if (gap > kLeastGap) {
    gap_ += gap;
    AddSentence(notice_, fmt::format("gap of {:.1f} s in {} (at {:.1f} s of the drive)", gap, NameOf(clips_[clip_]),
                                     begin_ + before + clock_.Interval()));
  }
  latest_ = std::max(latest_, begin_ + time);
  return begin_ + time;
}

// Seconds from the beginning of the clip to the end of its last frame, whatever times replace its own. Empty if the
// container does not tell, or if every image has a time by its number, so that none may be missing.
std::optional<double> ClipReader::EndByStamps() const {
  const VideoHeader& header = headers_[clip_];
  if (!options_.timed || !latest_stamp_ || !header.begin || header.rate <= 0) return std::nullopt;
  return *latest_stamp_ - *header.begin + 1 / header.rate;
}

void ClipReader::Close() {
  video_.reset();
  open_ = false;
  new_from_ = -std::numeric_limits<double>::infinity();
  const VideoHeader& header = headers_[clip_];
  double seconds = frames_ > 0 ? clock_.time() + clock_.Interval() : 0;
  // By other times than the video's own, only a count can tell.
  const bool comparable = header.counted || (options_.timed && !options_.fps);
  const std::string why = comparable ? EndsTooEarly(header, frames_, seconds, EndByStamps()) : std::string();
  const std::string before = NameOf(clips_[clip_]);
  ends_early_ = why.empty() ? std::string() : before + ": " + why;
  if (why.empty() && options_.timed)
    AddSentence(notice_, LacksFrames(before, header, frames_, options_.fps.has_value()));
  if (++clip_ == clips_.size()) {
    if (ends_early_.empty()) ends_early_ = LackBefore(clip_);
    return;
  }
  AddSentence(notice_, ends_early_);
  AddSentence(lacks_, ends_early_);
  AddSentence(lacks_, LackBefore(clip_));
  if (!options_.timed) return;
  if (recorded_->Guessed() == clip_) {
    AddSentence(notice_,
                fmt::format("{} was made at the same time as {} (creation_time), and is taken to follow it: is "
                            "it of another camera?",
                            NameOf(clips_[clip_]), before));
  }
  double gap = recorded_->GapAfter(clip_ - 1, seconds);
  // What is missing of a damaged clip is a gap, too.
  if (gap == 0 && !ends_early_.empty() && !options_.fps) gap = std::max(Length(header) - seconds, 0.0);
  if (gap > 0) {
    BeginAfterGap(seconds, gap, "");
  } else {
    BeginNext(seconds);
  }
  tail_.Clear();
}

// The next clip begins so many seconds after the end of the one before, which lasts for `seconds`.
void ClipReader::BeginAfterGap(double seconds, double gap, const std::string& why) {
  gap_ += gap;
  AddSentence(notice_, fmt::format("gap of {:.1f} s between {} and {} (at {:.1f} s of the drive){}", gap,
                                   NameOf(clips_[clip_ - 1]), NameOf(clips_[clip_]), begin_ + seconds, why));
  begin_ += seconds + gap;
}

// Of the next clip, as its images tell: when it begins, and which of them are new. The one before lasts for `seconds`.
void ClipReader::BeginNext(double seconds) {
  VideoFile next(clips_[clip_]);
  VideoClock clock(options_.fps.value_or(next.header().rate), next.header().tick);
  cv::Mat first;
  const std::optional<double> begin = tail_.RepeatedBy([&]() -> std::optional<ClipImage> {
    if (!next.Advance()) return std::nullopt;
    const ClipImage image{clock.Next(options_.fps ? std::nullopt : next.Stamp()), next.Gray()};
    if (first.empty()) first = image.gray.clone();
    return image;
  });
  const double recorded = recorded_->OverlapAfter(clip_ - 1, seconds);
  const double likely_gap = begin ? 0 : recorded_->LikelyGapAfter(clip_ - 1, seconds);
  const bool jumps = !begin && recorded == 0 && !first.empty() && tail_.JumpsTo(first, likely_gap > 0);
  if (const double gap = jumps ? recorded_->GapAtJump(clip_ - 1, seconds) : 0; gap > 0) {
    BeginAfterGap(seconds, gap, ": the images show it, its length is known to a second");
    return;
  }
  likely_gap_ = likely_gap;
  const double end = begin_ + seconds;
  begin_ = begin.value_or(end);
  const std::string name = NameOf(clips_[clip_]);
  const std::string before = NameOf(clips_[clip_ - 1]);
  if (begin) {
    // Stamps of the two clips may differ by their ticks.
    new_from_ = end - 0.5 * clock_.Interval();
    overlap_ = fmt::format("{} repeats the last {:.1f} s of {}: images that clips repeat are left out", name,
                           end - *begin, before);
    return;
  }
  if (recorded > 0 && recorded <= kLongestOverlap && tail_.IsMoving()) {
    AddSentence(notice_,
                fmt::format("{} begins {:.1f} s before {} ends, by the times of recording, but does not repeat "
                            "its images: is it of another camera?",
                            name, recorded, before));
  } else if (jumps && recorded_->Guessed() != clip_) {
    AddSentence(notice_, fmt::format("images seem to be missing between {} and {} (at {:.1f} s of the drive), nothing "
                                     "tells for how long: the path may be too short there",
                                     before, name, end));
    unknown_gap_ = true;
  }
}

// The notice where the start that was asked for lies in the gap before the first image that is given.
std::string ClipReader::StartsInGap(double time) const {
  const double late = time - options_.start;
  if (late <= kLeastGap) return {};
  return fmt::format("--start lies in a gap of {:.1f} s: the path begins {:.1f} s later, at {:.1f} s of the drive",
                     gap_, late, time);
}

std::optional<DriveImage> ClipReader::Read() {
  while (clip_ < clips_.size()) {
    if (!open_) Open();
    if (!video_->Advance()) {
      Close();
      continue;
    }
    DriveImage image;
    if (const auto stamp = video_->Stamp()) latest_stamp_ = std::max(latest_stamp_.value_or(*stamp), *stamp);
    image.time = TimeNext();
    const int number = frames_++;
    if (image.time && *image.time < new_from_) continue;
    if (image.time && clip_ + 1 < clips_.size()) tail_.Add({*image.time, image.image.gray = video_->Gray()});
    if (passed_++ < skip_ || (image.time && *image.time < options_.start)) {
      // Nothing of the drive is before the first image that is given.
      gap_ = 0;
      unknown_gap_ = false;
      likely_gap_ = 0;
      notice_.clear();
      lacks_.clear();
      overlap_.clear();
      continue;
    }
    if (image.image.gray.empty()) image.image.gray = video_->Gray();
    image.image.read_direction = headers_[clip_].read_direction;
    image.name = fmt::format("{}: frame {}", clips_[clip_].string(), number);
    image.clip = static_cast<int>(clip_);
    const bool first = !std::exchange(begun_, true);
    if (!first) {
      image.gap = gap_;
      image.unknown_gap = unknown_gap_;
      image.likely_gap = likely_gap_;
    }
    const std::string late = first && passed_ > 1 && gap_ > 0 ? StartsInGap(*image.time) : std::string();
    // Before the first image: of clips of which no frame could be decoded.
    image.notice = !first || passed_ == 1 ? notice_ : late;
    // A start at the end of a gap leaves nothing of it.
    if (!first || passed_ == 1 || !late.empty()) image.lacks = lacks_;
    if (!first && !overlap_.empty() && !std::exchange(overlap_named_, true)) AddSentence(image.notice, overlap_);
    overlap_.clear();
    if (first) {
      AddSentence(image.notice, SeveralTracks(clips_, headers_));
      AddSentence(image.notice, OtherRate(options_.fps, headers_.front()));
    }
    gap_ = 0;
    unknown_gap_ = false;
    likely_gap_ = 0;
    notice_.clear();
    lacks_.clear();
    return image;
  }
  return std::nullopt;
}

}  // namespace turnscale
