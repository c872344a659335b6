// SPDX-License-Identifier: MIT
#include "turnscale/run/uncertain_scale.h"

#include <utility>

#include <fmt/format.h>

namespace turnscale {
namespace {

constexpr double kUncertain = 0.3;  // relative sigma
// Frames further apart, seconds, are across a loss of tracking.
constexpr double kLongestStep = 1;
// A car whose last keyframe is longer ago stands, seconds.
constexpr double kStands = 3;
// Less of the drive does not tell the speed of the rest, seconds.
constexpr double kLeastRest = 3;
// Share of the path's length from which on the error matters.
constexpr double kLeastShare = 0.03;

}  // namespace

std::optional<UncertainScale> FindUncertainScale(const std::vector<FrameResult>& frames) {
  UncertainScale part;
  double rest_seconds = 0;
  double rest_distance = 0;
  const FrameResult* before = nullptr;
  double keyframe_time = 0;
  double from = 0;  // of the part that goes on
  bool goes_on = false;
  for (const FrameResult& frame : frames) {
    if (!frame.is_measured() || frame.scale_state == ScaleState::kPending) continue;
    if (frame.keyframe) keyframe_time = frame.time;
    const FrameResult* last = std::exchange(before, &frame);
    if (!last || frame.time - last->time > kLongestStep || frame.time - keyframe_time > kStands) continue;
    const double seconds = frame.time - last->time;
    const double distance = (frame.world_from_camera->translation - last->world_from_camera->translation).norm();
    if (frame.scale_sigma <= kUncertain) {
      rest_seconds += seconds;
      rest_distance += distance;
      goes_on = false;
      continue;
    }
    if (!std::exchange(goes_on, true)) from = last->time;
    if (frame.time - from > part.to - part.from) {
      part.from = from;
      part.to = frame.time;
    }
    part.seconds += seconds;
    part.distance += distance;
  }
  if (part.seconds == 0 || rest_seconds < kLeastRest) return std::nullopt;
  part.expected = part.seconds * rest_distance / rest_seconds;
  return part;
}

std::string UncertainScaleText(const UncertainScale& part, double length) {
  if (part.length_error() < kLeastShare * length) return {};
  return fmt::format(
      "the scale is hardly known for {:.1f} s ({}from {:.1f} to {:.1f} s): the path there is {:.0f} m long, but about "
      "{:.0f} m at the mean speed of the rest",
      part.seconds, part.to - part.from < 0.9 * part.seconds ? "the longest part " : "", part.from, part.to,
      part.distance, part.expected);
}

}  // namespace turnscale
