// SPDX-License-Identifier: MIT
#include "turnscale/run/view_change.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// A view that was hidden for so long may have become another one.
constexpr double kLongestLoss = 1.0;  // seconds
// Landmarks in the last image before it, as a share of the usual number: with fewer, tracking was about to be lost.
constexpr double kLeastLandmarks = 0.5;

}  // namespace

std::vector<double> FindViewChanges(const std::vector<FrameResult>& frames, const std::vector<MapRestart>& restarts) {
  std::vector<double> inliers;
  for (const FrameResult& frame : frames)
    if (frame.is_measured()) inliers.push_back(frame.inliers);
  if (inliers.empty()) return {};
  const double least = kLeastLandmarks * Median(std::move(inliers));
  std::vector<double> times;
  for (const MapRestart& restart : restarts) {
    const auto first = std::ranges::lower_bound(frames, restart.frame, {}, &FrameResult::frame);
    const auto last = std::find_if(std::make_reverse_iterator(first), frames.rend(),
                                   [](const FrameResult& frame) { return frame.is_measured(); });
    if (first == frames.end() || last == frames.rend()) continue;
    const bool is_short = first->time - last->time < kLongestLoss;
    if (is_short && last->inliers >= least) times.push_back(last.base()->time);
  }
  return times;
}

std::string ViewChangeText(const std::vector<double>& times, double first_time) {
  if (times.empty()) return {};
  return fmt::format(
      "the view changes from one image to the next at {:.1f} s{}, where tracking began anew: if the video was cut "
      "there, the path lacks what was driven between; if clips that overlap were joined, it has it twice (give the "
      "clips "
      "themselves)",
      times.front() - first_time,
      times.size() > 1 ? fmt::format(" (the first of {} such places)", times.size()) : std::string());
}

}  // namespace turnscale
