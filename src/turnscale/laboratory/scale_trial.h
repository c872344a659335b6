// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/kinematics/lever_arm.h"
#include "turnscale/kinematics/pooled_scale.h"
#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/laboratory/scale_drive.h"
#include "turnscale/scale/absolute_scale_recovery.h"

namespace turnscale {

/// The paper's psi_th for its synthetic drive, rad (2.5 deg).
constexpr double kTurningAngle = 2.5 / 57.295779513082320877;

/// At which scale the turns are held.
enum class TurnScales {
  kEachItsOwn,  ///< what each turn shows by itself, as the paper does
  kSmoothed,    ///< what all turns say of it by their variances, the scale's logarithm walking randomly between them
};

/// How the absolute scale is recovered on the synthetic drive; the defaults are those of `turnscale run` but for the
/// paper's threshold psi_th.
struct ScaleEstimatorSettings {
  LeverArm lever_arm = {1.0, 0.0};
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  TurnDetectorOptions turns = {.min_step_angle = kTurningAngle};
  PooledScaleOptions pooled;
  TurnScales scales = TurnScales::kEachItsOwn;
  double drift_per_root_metre = 0.001;  ///< of the random walk, relative
  std::optional<int> most_turns;        ///< the first so many are used; unset: all
  ScaleRecoveryOptions recovery;
};

/// What the estimator gave.
struct RecoveredScale {
  Map map;                             ///< in metres
  std::vector<TurningRegion> regions;  ///< turns used; steps counted from 0 as the detector does
  bool found = false;                  ///< false: no turn gave a scale, and the map is the odometry's
  bool adjusted = false;               ///< false: between the turns the map has the first guess
};

/// Detects turns and observes the scale in them on the map as bundle adjustment has it; recovers it between them on the
/// map as the drifting odometry has it (Algorithm 1, (22), (24)-(30)). All turns at once, as none of them changes what
/// lies beyond its neighbours.
RecoveredScale RecoverScale(const ScaleEstimatorSettings& settings, double pixel_noise, const Map& adjusted,
                            Map drifted);

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

}  // namespace turnscale
