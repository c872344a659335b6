// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/kinematics/lever_arm.h"

namespace turnscale {

/// Prior knowledge of the car and its camera.
struct CarPrior {
  double lever_arm = 0;  ///< L: from the rear axle forward to the camera, metres
  /// Standard deviation of L, metres: a tape held from the camera to above the centre of the rear wheel.
  double lever_arm_sigma = kTapeSigma;
  double side_slip = kUsualSideSlip;             ///< c, s^2/m
  double side_slip_sigma = kUsualSideSlipSigma;  ///< 0 where c is known exactly
  /// Of the yaw error of Q, rad (0.3 deg: at which the calibration from the camera's motion is first used).
  double yaw_sigma = 0.3 / 57.295779513082320877;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

}  // namespace turnscale
