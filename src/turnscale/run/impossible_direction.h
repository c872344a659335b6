// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/odometry/results.h"

namespace turnscale {

/// A part of the path in which the rear axle moves as no car does: more than 20 degrees up or down, or more than 45
/// degrees sideways, relative to the direction in which it usually moves. Then tracking has failed, or has followed
/// something else than the scene.
struct ImpossibleDirection {
  double from = 0;  ///< time, seconds
  double to = 0;    ///< time, seconds
  /// Length of its path, metres; empty in a trajectory that is up to scale.
  std::optional<double> distance = std::nullopt;
  double up = 0;     ///< of the worst place, radians, by which the car moves upwards; negative: downwards
  double aside = 0;  ///< of the worst place, radians, by which it moves to the right; negative: to the left
};

/// All such parts, in the order of time. `frames`: poses of the camera, in metres or up to scale. `lever_arm`: metres;
/// 0 if it is unknown; up to scale it does not count. A direction is that of a metre of the path, or, up to scale, of
/// 0.5 s at the speed at which half of it is driven. It takes less than three seconds, is measured throughout without a
/// gap of a second, and turns by less than 40 degrees.
std::vector<ImpossibleDirection> FindImpossibleDirections(const std::vector<FrameResult>& frames, double lever_arm);

/// The warning, one line, with times counted from `first_time`; empty if there are none.
std::string ImpossibleDirectionText(const std::vector<ImpossibleDirection>& parts, double first_time = 0);

/// Their whole length, metres, as the error of the path's length: any part of it may be wrong. 0 for a trajectory that
/// is up to scale.
double LengthErrorOf(const std::vector<ImpossibleDirection>& parts);

}  // namespace turnscale
