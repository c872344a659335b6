// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/calibration/body_lean.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/linear_calibration.h"
#include "turnscale/calibration/refinement.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

struct CalibrationOptions {
  RefinementOptions refinement;
  /// Least turning, right and left together, before the roll and the split of the camera's heading into yaw and pitch
  /// are believed, rad (30 deg).
  double min_turn = 30 / kDegreesPerRadian;
  /// The linear solution counts as unique from this ratio of its two smallest singular values on. The noise of a
  /// straight drive alone gives 1.9 in the median and up to 2.6 over 100 frames, one right angle gives 3.5 and more.
  double min_confidence = 2.6;
  /// Turns that are counted for the report begin here, rad (15 deg in one direction).
  double counted_turn = 15 / kDegreesPerRadian;

  /// Compensate the roll of the body in turns. The paper's car is rigid.
  bool body_lean = true;
  /// Standard deviation of what a drive's own motion may be off by from begin to end, rad (0.15 deg): the lens and its
  /// mounting for an odometry, a heading for an inertial one, the road's camber. Yaw and pitch of one drive do not
  /// show it; on KITTI, ground truth and stereo odometry differ by 0.1 to 0.3 deg.
  double motion_bias = 0.15 / kDegreesPerRadian;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The camera-to-vehicle rotation and its covariance.
struct Calibration {
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();  ///< the paper's Q
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the small rotation about vehicle axes, rad^2
  YawPitchRoll angles;                                   ///< rad
  YawPitchRoll sigma;                                    ///< rad
  LinearSolution linear;                                 ///< where the refinement started
  Refinement refinement;
  BodyLean lean;
  int steps = 0;
  int reversed = 0;    ///< steps driven backwards
  int turns = 0;       ///< of more than CalibrationOptions::counted_turn
  double turning = 0;  ///< sum of |psi|, rad
  bool observable = false;
  std::string problem;  ///< what is not observable, one line; empty if all three angles are
};

/// Q from the camera's motion: the linear solution, the refinement, and the refinement again without the body's lean.
///
/// Assumptions: the car mostly drives forward (the other direction counts as reversing), and the camera is less than
/// 90 degrees from upright. Throws InputError where there are fewer than three steps, or
/// they have no direction of travel in common.
Calibration Calibrate(const std::vector<CameraStep>& steps, const CalibrationOptions& options = {});

/// The steps in the main direction of travel, those of reversing inverted. Counts the latter in `reversed`.
std::vector<CameraStep> DrivenForward(std::vector<CameraStep> steps, int& reversed);

}  // namespace turnscale
