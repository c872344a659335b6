// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/step_residual.h"
#include "turnscale/geometry/angle.h"

namespace turnscale {

/// Model of the travelled distances.
enum class TravelModel {
  /// The odometry's step lengths hold over a turn: one lever arm, in the odometry's unit, for every piece of the drive
  /// that turns enough to show it. Yaw is then where the line of travel direction over curvature meets zero curvature.
  kSteady,
  /// The paper's (15): every step has a free rho_j > 0. Yaw is bounded by the steps in which the camera would swing
  /// inwards, or out by more than any lever arm.
  kFree,
};

/// Standard deviations of a step's measurements, radians: for the weights of the residuals.
struct StepNoise {
  double rotation = 0.1 / kDegreesPerRadian;    ///< off the turning axis; odometry and the body on its springs
  double vertical = 0.5 / kDegreesPerRadian;    ///< direction of travel, up and down
  double horizontal = 0.5 / kDegreesPerRadian;  ///< direction of travel, left and right
};

struct RefinementOptions {
  TravelModel travel = TravelModel::kSteady;
  /// r_th of (16): this share of the residuals is below the Huber threshold, anew in each iteration.
  double huber_share = 0.6;
  /// Weight rotations and directions by their observed spread; otherwise both count alike, as in (15).
  bool weigh_by_spread = true;
  /// Standard deviation of the road's bank and the body's lean in a turn, rad (1.5 deg). It tilts the turning axis for
  /// all of a turn, so the spread of single steps does not show it; it goes into the covariance of the roll alone.
  /// The roll that right angles of KITTI show scatters by as much; 0 is a flat world.
  double road_bank = 1.5 / kDegreesPerRadian;
  /// Standard deviation of the change of grade, and of the body's pitch, during a turn of some 12 deg and more, rad
  /// (1.2 deg): the smaller the turn, the more it tilts the turning axis. In the turns of KITTI that a level road would
  /// give the same axis, this tilts it by 5 to 6 deg rms below 20 deg, 2 deg at 40 deg, and 1 deg at right angles.
  double grade_change = 1.2 / kDegreesPerRadian;
  int max_iterations = 100;
  double tolerance = 1e-6;  ///< rad; the last update of the rotation

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// What is known of Q before: a rotation, and the inverse covariance of the small rotation about vehicle axes that
/// corrects it, 1/rad^2.
struct RotationPrior {
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

struct Refinement {
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  /// Of the small rotation about vehicle axes (x: pitch, y: yaw, z: roll), rad^2: from the final normal equations,
  /// scaled by the residuals. Infinite diagonal where the equations are singular.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< the normal equations themselves, prior included
  StepNoise noise;                                        ///< as estimated
  std::vector<double> lever_arms;  ///< kSteady: one per piece of the drive, in the odometry's unit
  std::vector<double> psi;         ///< one per step, rad
  int iterations = 0;
  bool converged = false;
};

/// The step without its length and times. The direction of a step of length 0 is forward.
StepMeasurement MeasurementOf(const CameraStep& step);

/// The full refinement (15), (16) by Gauss-Newton on the unit quaternion. What belongs to one step alone (psi_j, rho_j)
/// is eliminated step by step, so the cost grows linearly with their number.
///
/// L is not needed: all is in units of L with kFree, in the odometry's unit with kSteady.
Refinement RefineRotation(const std::vector<StepMeasurement>& steps, const Eigen::Quaterniond& start,
                          const RefinementOptions& options = {},
                          const std::optional<RotationPrior>& prior = std::nullopt);

/// What is known before, and in addition that the roll is this rotation's, as far as roads' banks let one know.
RotationPrior WithSameRoll(const RefinementOptions& options, const std::optional<RotationPrior>& prior,
                           const Eigen::Quaterniond& vehicle_from_camera);

/// RefineRotation, with the axis of the car's turns in the camera's frame (TurningAxis) known to be within 20 degrees
/// of the vertical. Where few of the steps turn, (15) has a second minimum that takes the car's pitching for its
/// turning and the turns for outliers; then the roll is the start's. Empty where even so the turns contradict the
/// result.
std::optional<Refinement> RefineRotationAbout(const Eigen::Vector3d& turning_axis,
                                              const std::vector<StepMeasurement>& steps,
                                              const Eigen::Quaterniond& start, const RefinementOptions& options = {},
                                              const std::optional<RotationPrior>& prior = std::nullopt);

/// Whether the turning axis is farther from the vertical of this rotation than roads and noise can make it.
bool ContradictsAxis(const Eigen::Vector3d& turning_axis, const Eigen::Quaterniond& vehicle_from_camera);

}  // namespace turnscale
