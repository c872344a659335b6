// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/synthetic_drive.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// A car of tests, its camera and a step of its corners.
inline const Eigen::Quaterniond kMounting = RotationFromYawPitchRoll({0.03, -0.05, 0.01});
constexpr double kLeverArm = 1.2;
constexpr double kCornerStep = M_PI / 2 / 22;

/// Two corners of 90 degrees with a street between.
inline const std::vector<DriveSegment> kTwoCorners = {
    {12, 0.8, 0}, {22, 0.6, kCornerStep}, {25, 0.8, 0}, {22, 0.6, -kCornerStep}, {12, 0.8, 0}};

/// All of the car is given.
inline OdometryOptions KnownCar() {
  OdometryOptions options;
  options.vehicle.lever_arm = kLeverArm;
  options.vehicle.vehicle_from_camera = kMounting;
  options.vehicle.calibrate_camera = false;
  return options;
}

}  // namespace turnscale
