// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/results.h"

namespace turnscale {

/// A part of the path in which the rear axle moves as no car does: more than 20 degrees up or down, or more than 45
/// degrees sideways, relative to the direction in which it usually moves. Then tracking has failed, or has followed
/// something else than the scene.
struct ImpossibleDirection {
  double from = 0;      ///< time, seconds
  double to = 0;        ///< time, seconds
  double distance = 0;  ///< length of its path, metres
  double up = 0;        ///< of the worst place, radians, by which the car moves upwards; negative: downwards
  double aside = 0;     ///< of the worst place, radians, by which it moves to the right; negative: to the left
};

/// All such parts, in the order of time. `frames`: poses of the camera in metres; there are none in a trajectory that
/// is up to scale. `lever_arm`: metres; 0 if it is unknown. A direction is that of a metre of the path that takes less
/// than three seconds, is measured throughout without a gap of a second, and turns by less than 40 degrees.
std::vector<ImpossibleDirection> FindImpossibleDirections(const std::vector<FrameResult>& frames, double lever_arm);

/// The warning, one line, with times counted from `first_time`; empty if there are none.
std::string ImpossibleDirectionText(const std::vector<ImpossibleDirection>& parts, double first_time = 0);

/// Their whole length, metres, as the error of the path's length: any part of it may be wrong.
double LengthErrorOf(const std::vector<ImpossibleDirection>& parts);

}  // namespace turnscale
