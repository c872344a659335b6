// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/results.h"

namespace turnscale {

/// A part of the drive whose path no car has driven: where it begins or ends, the speed changes by more than 15 m/s^2,
/// or it is above 90 m/s (324 km/h). Then something else than the scene was followed, such as a lorry ahead, the unit
/// of the map has changed, or the times are wrong. Or it leads across a gap in the images of 1 to 5 s that is measured
/// on both sides, and is longer or shorter than a car's that brakes and accelerates with 5 m/s^2.
struct ImpossibleMotion {
  double from = 0;        ///< time, seconds
  double to = 0;          ///< time, seconds
  double distance = 0;    ///< length of its path, metres
  double most_speed = 0;  ///< m/s
  /// Length at the speed before and after it, metres; where it is faster than a car, at the usual one of the rest, or 0
  /// if there is no rest.
  double expected = 0;

  bool IsFasterThanACar() const;
};

/// All such parts, in the order of time. `frames`: poses in metres; there are none in a trajectory that is up to scale.
/// The speed is that of half a second, without single steps that are much longer than their neighbours: those are a
/// matter of the times (TimeWarnings). Of the two sides of a change, that which lasts for less time is taken to be
/// wrong, unless the other is faster than a car. A car that stands is not looked at: it may have stopped while no image
/// was recorded.
std::vector<ImpossibleMotion> FindImpossibleMotion(const std::vector<FrameResult>& frames);

/// The warning, one line, with times counted from `first_time`; empty if there are none.
std::string ImpossibleMotionText(const std::vector<ImpossibleMotion>& parts, double first_time = 0);

/// Error of the path's length that they suggest, metres.
double LengthErrorOf(const std::vector<ImpossibleMotion>& parts);

}  // namespace turnscale
