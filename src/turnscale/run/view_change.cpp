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
// Landmarks in the last image before it, as a share of the usual number: with fewer, tracking was about to be lost.
constexpr double kLeastLandmarks = 0.5;

}  // namespace

std::vector<double> FindViewChanges(const std::vector<FrameResult>& frames, const std::vector<MapRestart>& restarts,
                                    const std::vector<double>& seams) {
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
  std::vector<double> times;
  for (const MapRestart& restart : restarts) {
    const auto first = std::ranges::lower_bound(frames, restart.frame, {}, &FrameResult::frame);
    const auto last = std::find_if(std::make_reverse_iterator(first), frames.rend(),
                                   [](const FrameResult& frame) { return frame.is_measured(); });
    if (first == frames.end() || last == frames.rend()) continue;
    const double time = last.base()->time;
    const bool at_seam = std::ranges::any_of(seams, [&](double seam) { return std::abs(time - seam) < kAtSeam; });
    if (first->time - last->time < longest && last->inliers >= least && !at_seam) times.push_back(time);
  }
  return times;
}

std::string ViewChangeText(const std::vector<double>& times, double first_time) {
  if (times.empty()) return {};
  return fmt::format(
      "the view changes from one image to the next at {:.1f} s{}, where tracking began anew: if the video was cut "
      "there, the path lacks what was driven between; if clips that overlap were joined, it has it twice (give the "
      "clips themselves)",
      times.front() - first_time,
      times.size() > 1 ? fmt::format(" (the first of {} such places)", times.size()) : std::string());
}

}  // namespace turnscale
