// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "turnscale/geometry/angle.h"
#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/laboratory/parallel_runs.h"
#include "turnscale/laboratory/scale_drive.h"
#include "turnscale/odometry/options.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// The paper's psi_th for its synthetic drive, rad (2.5 deg).
constexpr double kTurningAngle = 2.5 / kDegreesPerRadian;

/// The car of the synthetic drive, known exactly, its pixels, whose errors are independent, and the paper's psi_th. All
/// else as `turnscale run` has it.
OdometryOptions SyntheticDriveOdometry();

/// How the absolute scale is recovered on the synthetic drive.
struct ScaleEstimatorSettings {
  /// Of these, vehicle, steps and scale count.
  OdometryOptions odometry = SyntheticDriveOdometry();
  /// Each single-turn scale is a measurement with a variance instead of an equality constraint.
  bool weighs_turns = false;
  /// The first so many turns are used; unset: all. Where turns are smoothed, the others still tell of the scale.
  std::optional<int> most_turns;
};

/// What the estimator gave.
struct RecoveredScale {
  Map map;                             ///< in metres; the odometry's where no turn gave a scale
  std::vector<TurningRegion> regions;  ///< turns used; steps counted from 0 as the detector does
  bool converged = false;              ///< the recovery ended at its minimum
  /// Relative standard deviation of the path length that the estimator states; infinite where no turn gave a scale.
  double length_sigma = std::numeric_limits<double>::infinity();
  std::optional<CarRefinement> car;  ///< as refined from the drive
};

/// Detects the turns, observes the scale in them and recovers it between them (Algorithm 1, (22), (24)-(30)), on the
/// map as the drifting odometry has it. All turns at once, as none of them changes what lies beyond its neighbours.
/// `pixel_noise` is the standard deviation of the map's pixels. Throws InputError where the lever arm is not given or
/// an option of the recovery makes no sense.
RecoveredScale RecoverScale(const ScaleEstimatorSettings& settings, double pixel_noise, Map map);

/// The quantities of Table I over a set of steps: root mean squares of the errors.
struct ScaleErrors {
  double psi = 0;         ///< rad
  double theta = 0;       ///< rad
  double turn_scale = 0;  ///< metres a step, steps of turns
  double turn_ratio = 0;  ///< (33) as a share, steps of turns
  double scale = 0;       ///< all steps
  double ratio = 0;
};

/// Errors of world_from_camera (one a keyframe) over the steps from station to station. A step counts as turning where
/// the car truly turns by `turning_angle` (rad) or more.
ScaleErrors MeasureScale(const ScaleDrive& drive, const std::vector<RigidTransform>& world_from_camera,
                         const Eigen::Quaterniond& vehicle_from_camera, double turning_angle);

/// Poses of a map's keyframes.
std::vector<RigidTransform> KeyframePoses(const Map& map);

/// Standard deviations of the errors of the car's given parameters.
struct CarErrors {
  double lever_arm = 0;  ///< metres
  double side_slip = 0;  ///< s^2/m
  double yaw = 0;        ///< of the camera, rad
};

/// The paper's Monte-Carlo evaluation of the absolute scale recovery (V-B 2, Table I, Fig. 10).
struct ScaleTrials {
  ScaleDriveOptions drive;
  /// Estimators that are compared on the same drives.
  std::vector<ScaleEstimatorSettings> estimators = std::vector<ScaleEstimatorSettings>(1);
  /// Drawn once a run and added to what each estimator is told. A side slip below 0 is told as 0.
  CarErrors told_wrong;
  int runs = 100;
  int jobs = 1;
  std::uint64_t seed = 1;
  RunProgress progress;
};

/// An error and the standard deviation that the estimator states for it; infinite where it states none.
struct StatedError {
  double error = 0;
  double sigma = std::numeric_limits<double>::infinity();
};

/// What one run gives.
struct ScaleTrial {
  ScaleErrors odometry;                ///< of the paper's noisy odometry (ScaleDrive::odometry), for comparison
  ScaleErrors adjusted;                ///< of the map that the recovery starts from
  std::vector<ScaleErrors> recovered;  ///< one for each estimator
  std::vector<char> converged;         ///< one flag for each: the recovery ended at its minimum
  std::vector<StatedError> length;     ///< of the logarithm of the path length, one for each
  std::vector<StatedError> side_slip;  ///< s^2/m, against what `estimators` are told before errors are added
};

/// One entry per run; every run has points and noise of its own. Same options, same bits for any number of jobs. Empty
/// where `progress` stopped it. Throws as MakeScaleDrive, PointOdometry and RecoverScale do.
std::vector<ScaleTrial> RunScaleTrials(const ScaleTrials& trials);

/// Mean and standard deviation over the runs.
struct MeanAndSpread {
  double mean = 0;
  double spread = 0;
};
MeanAndSpread MeanAndSpreadOf(const std::vector<double>& values);

}  // namespace turnscale
