// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/calibration/camera_step.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

struct LeverArmFitOptions {
  /// Fit c of L_eff = L - c v^2 as well. Needs turns at different speeds; at one speed, L and c are indistinguishable.
  bool side_slip = false;
  /// Assumed c otherwise, s^2/m.
  double assumed_side_slip = 0;
  double assumed_side_slip_sigma = 0;  ///< its standard deviation, s^2/m
  /// Relative standard deviation of the lever arm due to the intrinsics.
  double intrinsics_sigma = 0;
  /// A lever arm with a larger relative sigma is rejected.
  double max_relative_sigma = 0.3;
  /// What gives the metres, for messages.
  std::string source_of_metres = "the metric scale";

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The lever arm estimated from metric motion.
struct LeverArmFit {
  LeverArm lever_arm;
  double sigma_length = 0;      ///< metres
  double sigma_side_slip = 0;   ///< s^2/m, estimated or assumed
  double slip_correlation = 0;  ///< of the errors of L and c: turns at one speed show L - c v^2 only
  bool slip_fitted = false;     ///< c was estimated
  bool slip_at_bound = false;   ///< the best c is below 0; it was fixed at 0
  int turning_steps = 0;        ///< that turn by at least 2 deg
  double speed_spread = 0;      ///< standard deviation of v^2 over the turning steps, over their mean

  /// Standard deviation of L if c were exact, metres.
  double SigmaAtExactSlip() const {
    return sigma_length * std::sqrt(std::max(1 - slip_correlation * slip_correlation, 0.0));
  }
};

/// A metric drive and its camera-to-vehicle rotation.
struct MetricDrive {
  std::vector<CameraStep> steps;  ///< metres
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
};

/// L, and c where asked for, common to all drives (end of section III): robust least squares of the pooled line
///   s sin(theta - psi/2) = (L - c v^2) 2 sin(psi/2) + s yaw + h roll
/// (s and c v^2 negative in reverse), with a separate yaw for each drive, so that the error of Q does not bias the
/// lever arm. The body's roll in a step moves the camera sideways; its height h above the roll axis is kUsualRollHeight
/// +- kUsualRollHeightSigma. Sigma covers errors of the motion that are common to a turn (CovarianceOfFit), c and the
/// intrinsics. It does not cover what else all turns share: the metres themselves.
/// Throws InputError where the drives turn too little, or give no lever arm: not above 0, longer than a car, too
/// uncertain, or indistinguishable from c.
LeverArmFit FitLeverArm(const std::vector<MetricDrive>& drives, const LeverArmFitOptions& options = {});

}  // namespace turnscale
