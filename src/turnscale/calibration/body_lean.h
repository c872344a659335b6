// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "turnscale/calibration/camera_step.h"

namespace turnscale {

/// How a car's body leans outwards in turns, on its springs: in proportion to the sideways acceleration. It tilts the
/// axis that the camera turns about, which would pass for a roll of the camera where turns to one side prevail.
struct BodyLean {
  /// rad of leaning right over the sideways acceleration to the right (unit of length / s^2); not above 0.
  double per_acceleration = 0;
  double sigma = 0;
  /// The mean lean over the turning, weighed as it enters the camera's roll, over per_acceleration.
  double mean_acceleration = 0;
};

/// Reads the lean from the roll that the camera makes where a turn begins and ends, not from the tilt itself: robust
/// regression of the roll over some steps on the change of acceleration. `vehicle_from_camera` is the paper's Q, good
/// to some degrees. 0 where too few steps follow each other, or the body seems to lean inwards.
BodyLean FitBodyLean(const std::vector<CameraStep>& steps, const Eigen::Quaterniond& vehicle_from_camera);

/// The steps as a body that does not lean would have made them.
std::vector<CameraStep> Levelled(std::vector<CameraStep> steps, const Eigen::Quaterniond& vehicle_from_camera,
                                 const BodyLean& lean);

}  // namespace turnscale
