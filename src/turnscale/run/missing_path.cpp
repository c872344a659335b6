// SPDX-License-Identifier: MIT
#include "turnscale/run/missing_path.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/quantiles.h"
#include "turnscale/frames/frame_reader.h"

namespace turnscale {
namespace {

bool IsTracked(const FrameResult& frame) { return frame.state == TrackingState::kTracked; }

// Between frames that follow one another without a gap, seconds.
double UsualInterval(const std::vector<FrameResult>& frames) {
  std::vector<double> intervals;
  for (size_t i = 1; i < frames.size(); ++i)
    if (const double interval = frames[i].time - frames[i - 1].time; interval <= kLeastGap)
      intervals.push_back(interval);
  return intervals.empty() ? 0 : Median(std::move(intervals));
}

}  // namespace

std::vector<MissingPart> FindMissingParts(const std::vector<FrameResult>& frames) {
  const double interval = UsualInterval(frames);
  std::vector<MissingPart> parts;
  bool open = false;
  bool begun = false;
  for (size_t i = 0; i < frames.size(); ++i) {
    const FrameResult& frame = frames[i];
    const bool after_gap = i > 0 && frame.time - frames[i - 1].time > kLeastGap;
    if (open) parts.back().to = after_gap ? frames[i - 1].time : frame.time;
    // A duplicate shows what its neighbours measure.
    const bool lost = !IsTracked(frame) && (open || after_gap || frame.state != TrackingState::kRepeated);
    if (after_gap) parts.push_back({MissingReason::kNotRecorded, frames[i - 1].time + interval, frame.time, 0});
    open = open && !after_gap;
    const bool unreadable = frame.state == TrackingState::kUnreadable;
    if (lost && !open)
      parts.push_back({unreadable ? MissingReason::kUnreadable : MissingReason::kLost, frame.time, frame.time, 0});
    open = lost;
    begun = begun || IsTracked(frame);
    if (!lost) continue;
    ++parts.back().frames;
    MissingReason& reason = parts.back().reason;
    if (!begun)
      reason = MissingReason::kNotBegun;
    else if (!unreadable && frame.state != TrackingState::kRepeated)
      reason = MissingReason::kLost;
  }
  return parts;
}

std::vector<MissingPart> LongestParts(const std::vector<MissingPart>& parts, size_t most) {
  std::vector<MissingPart> longest = parts;
  const auto by_length = [](const MissingPart& a, const MissingPart& b) { return a.to - a.from > b.to - b.from; };
  std::stable_sort(longest.begin(), longest.end(), by_length);
  longest.resize(std::min(most, longest.size()));
  std::sort(longest.begin(), longest.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
  return longest;
}

double TotalSeconds(const std::vector<MissingPart>& parts) {
  double seconds = 0;
  for (const MissingPart& part : parts) seconds += part.to - part.from;
  return seconds;
}

std::optional<MissingPart> PartBeforeMap(const std::vector<FrameResult>& frames) {
  const auto first = std::ranges::find_if(frames, IsTracked);
  if (first == frames.begin() || first == frames.end()) return std::nullopt;
  return MissingPart{MissingReason::kNotBegun, frames.front().time, first->time,
                     static_cast<int>(first - frames.begin())};
}

bool IsLate(const MissingPart& before, const std::vector<FrameResult>& frames, double least_share) {
  const double missing = before.to - before.from;
  const double seconds = frames.back().time - frames.front().time;
  return missing >= kLateSeconds && missing >= least_share * seconds;
}

bool IsMostOfDrive(const MissingPart& before, const std::vector<FrameResult>& frames) {
  constexpr double kMost = 0.5;
  return IsLate(before, frames, kMost);
}

std::string NoMapBeforeText(const MissingPart& before, int frames) {
  return fmt::format("no map could be started before {:.1f} s ({} of {} frames)", before.to, before.frames, frames);
}

std::string LateBeginningText(const MissingPart& before, int frames, const SeenImages& seen) {
  if (seen.Still()) return {};
  const std::string cause = seen.Cause();
  return NoMapBeforeText(before, frames) + (cause.empty() ? "" : ": " + cause);
}

double LengthBefore(const MissingPart& before, const std::vector<FrameResult>& frames) {
  constexpr double kSeconds = 1;
  const auto first = std::ranges::lower_bound(frames, before.to, {}, &FrameResult::time);
  if (first == frames.end() || !first->world_from_camera) return 0;
  auto last = first;
  while (last + 1 != frames.end() && last->time < before.to + kSeconds) ++last;
  const double seconds = last->time - first->time;
  if (!(seconds > 0) || !last->world_from_camera) return 0;
  const double length = (last->world_from_camera->translation - first->world_from_camera->translation).norm();
  return length / seconds * (before.to - before.from);
}

bool IsMissing(const std::vector<MissingPart>& parts, double from, double to) {
  const auto part =
      std::partition_point(parts.begin(), parts.end(), [&](const MissingPart& earlier) { return earlier.to <= from; });
  return part != parts.end() && part->from < to;
}

const char* MissingReasonName(MissingReason reason) {
  switch (reason) {
    case MissingReason::kNotBegun:
      return "before initialisation";
    case MissingReason::kNotRecorded:
      return "not recorded";
    case MissingReason::kUnreadable:
      return "images unreadable";
    default:
      return "tracking lost";
  }
}

std::string MissingPartText(const MissingPart& part) {
  std::string text = fmt::format("{} from {:.1f} s to {:.1f} s", MissingReasonName(part.reason), part.from, part.to);
  if (part.frames > 0) text += fmt::format(" ({} frame{})", part.frames, part.frames == 1 ? "" : "s");
  return text;
}

}  // namespace turnscale
