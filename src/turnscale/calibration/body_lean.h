// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "turnscale/calibration/camera_step.h"

namespace turnscale {

/// Outward roll of a sprung car body in turns, in proportion to the lateral acceleration (roll gradient). It tilts the
/// axis that the camera turns about, which looks like a roll of the camera if most turns go to one side.
struct BodyLean {
  /// rad of leaning right over the sideways acceleration to the right (unit of length / s^2); not above 0.
  double per_acceleration = 0;
  double sigma = 0;
  /// The mean lean over the turning, weighed as it enters the camera's roll, over per_acceleration.
  double mean_acceleration = 0;
};

/// Estimates it from the camera's rolling motion at the beginning and end of turns, not from the tilt itself: robust
/// regression of the roll over some steps on the change of acceleration. `vehicle_from_camera` is the paper's Q, good
/// to some degrees. 0 where too few steps follow each other, or the body seems to lean inwards.
BodyLean FitBodyLean(const std::vector<CameraStep>& steps, const Eigen::Quaterniond& vehicle_from_camera);

/// The steps as a body that does not lean would have made them.
std::vector<CameraStep> Levelled(std::vector<CameraStep> steps, const Eigen::Quaterniond& vehicle_from_camera,
                                 const BodyLean& lean);

}  // namespace turnscale
