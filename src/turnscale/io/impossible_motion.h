// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/results.h"

namespace turnscale {

/// A part of the drive whose path no car has driven: at its ends, the speed changes by more than 15 m/s^2. Then
/// something else than the scene was followed, such as a lorry ahead, or the unit of the map has changed.
struct ImpossibleMotion {
  double from = 0;      ///< time, seconds
  double to = 0;        ///< time, seconds
  double distance = 0;  ///< length of its path, metres
  double expected = 0;  ///< the same with the speed before and after it, metres
};

/// All such parts, in the order of time. `frames`: poses in metres; there are none in a trajectory that is up to scale.
/// Speeds are means over half a second of measured poses. Parts less than 15 s apart are one. Where the speed changes
/// only once, either side may be wrong; the shorter one is taken. A car that stands is not looked at: it may have
/// stopped while no image was recorded.
std::vector<ImpossibleMotion> FindImpossibleMotion(const std::vector<FrameResult>& frames);

/// The warning, one line; empty if there are none.
std::string ImpossibleMotionText(const std::vector<ImpossibleMotion>& parts);

/// Error of the path's length that they suggest, metres.
double LengthErrorOf(const std::vector<ImpossibleMotion>& parts);

}  // namespace turnscale
