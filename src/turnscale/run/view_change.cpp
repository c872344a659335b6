// SPDX-License-Identifier: MIT
#include "turnscale/run/view_change.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/quantiles.h"
#include "turnscale/odometry/options.h"

namespace turnscale {
namespace {

// Intervals between images, beside the time after which tracking gives up, within which the next map begins where all
// images show the scene.
constexpr double kIntervals = 2.5;
// Clips that follow one another are looked at elsewhere.
constexpr double kAtSeam = 0.15;  // seconds
// Of the features and of the landmarks of the last tracked image, the shares that are found in the first one that is
// not tracked, together. Where the view changes at once, hardly any is; in poor light, tracking is lost bit by bit.
constexpr double kMostFound = 0.6;
// Contrast of that image over that of the last tracked one: with less, the scene is hidden, and no other one is shown.
constexpr double kLeastContrastLeft = 0.35;
// Landmarks in the last image before it, as a share of the usual number: with fewer, tracking was about to be lost.
constexpr double kLeastLandmarks = 0.5;

// Of what the image before shows. Where only a sample of it was looked for, what the one before that shows.
double ShareFound(const FrameResult& lost, const FrameResult& last, const FrameResult* before) {
  const bool may_be_sample =
      before && before->is_measured() && last.time - before->time < TrackingOptions().sampled_interval;
  const int features = std::max(last.tracked, may_be_sample ? before->tracked : 0);
  const int landmarks = std::max(last.inliers, may_be_sample ? before->inliers : 0);
  return static_cast<double>(lost.tracked) / std::max(features, 1) +
         static_cast<double>(lost.inliers) / std::max(landmarks, 1);
}

}  // namespace

std::vector<double> FindViewChanges(const std::vector<FrameResult>& frames, const std::vector<MapRestart>& restarts,
                                    const std::vector<int>& repeated, const std::vector<double>& seams) {
  std::vector<double> inliers;
  std::vector<double> intervals;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].is_measured()) inliers.push_back(frames[i].inliers);
    if (i > 0) intervals.push_back(frames[i].time - frames[i - 1].time);
  }
  if (inliers.empty() || intervals.empty()) return {};
  const double interval = Median(std::move(intervals));
  const TrackingOptions limits;
  const double longest = std::max(limits.max_lost_seconds, limits.min_lost_frames * interval) + kIntervals * interval;
  const double least = kLeastLandmarks * Median(std::move(inliers));
  // In other frames nothing was looked for, so that they do not tell what was still to be found.
  const auto is_searched = [&](const FrameResult& frame) {
    return frame.state != TrackingState::kUnreadable && !std::ranges::binary_search(repeated, frame.frame);
  };
  std::vector<double> times;
  for (const MapRestart& restart : restarts) {
    const auto first = std::ranges::lower_bound(frames, restart.frame, {}, &FrameResult::frame);
    const auto last = std::find_if(std::make_reverse_iterator(first), frames.rend(),
                                   [](const FrameResult& frame) { return frame.is_measured(); });
    if (first == frames.end() || last == frames.rend()) continue;
    const auto lost = std::find_if(last.base(), first, is_searched);
    if (lost == first) continue;
    const FrameResult* before = std::next(last) == frames.rend() ? nullptr : &*std::next(last);
    if (ShareFound(*lost, *last, before) > kMostFound || restart.contrast_left < kLeastContrastLeft) continue;
    const double time = lost->time;
    const bool at_seam = std::ranges::any_of(seams, [&](double seam) { return std::abs(time - seam) < kAtSeam; });
    if (first->time - last->time < longest && last->inliers >= least && !at_seam) times.push_back(time);
  }
  return times;
}

std::vector<FrozenPart> FindFrozenParts(const std::vector<FrameResult>& frames, const std::vector<int>& repeated) {
  constexpr double kLeastSeconds = 0.5;
  const int count = static_cast<int>(frames.size());
  const auto is_frozen = [&](int frame) { return frame < count && frames[frame].state == TrackingState::kBridged; };
  std::vector<FrozenPart> parts;
  for (std::size_t i = 0; i < repeated.size(); ++i) {
    if (!is_frozen(repeated[i])) continue;
    const int before = std::max(repeated[i] - 1, 0);
    while (i + 1 < repeated.size() && repeated[i + 1] == repeated[i] + 1 && is_frozen(repeated[i + 1])) ++i;
    const int after = std::min(repeated[i] + 1, count - 1);
    FrozenPart part{.from = frames[before].time, .to = frames[after].time, .at_end = repeated[i] == count - 1};
    for (int k = before + 1; k <= after; ++k) {
      const auto& last = frames[k - 1].world_from_camera;
      const auto& now = frames[k].world_from_camera;
      if (last && now) part.length += (now->translation - last->translation).norm();
    }
    if (!parts.empty() && part.from <= parts.back().to) {
      part.from = parts.back().from;
      part.length += parts.back().length;
      parts.pop_back();
    }
    if (part.to - part.from >= kLeastSeconds) parts.push_back(part);
  }
  return parts;
}

std::string FrozenPartText(const FrozenPart& part, double first_time, const std::string& unit) {
  const std::string until = part.at_end ? "the end" : fmt::format("{:.1f} s", part.to - first_time);
  return fmt::format("the picture is frozen from {:.1f} s to {}: the path there is a guess of {:.0f} {}{}",
                     part.from - first_time, until, part.length, unit,
                     part.at_end ? ", as the car may have stopped" : ", and may go on in a wrong direction after it");
}

std::string ViewChangeText(const std::vector<double>& times, double first_time) {
  if (times.empty()) return {};
  return fmt::format(
      "the view changes from one image to the next at {:.1f} s{}, where tracking began anew: if the video was cut "
      "there, the path lacks what was driven between, and may go on in a wrong direction; if clips that overlap were "
      "joined, it has it twice (give the clips themselves)",
      times.front() - first_time,
      times.size() > 1 ? fmt::format(" (the first of {} such places)", times.size()) : std::string());
}

}  // namespace turnscale
