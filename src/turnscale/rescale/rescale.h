// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/trajectory.h"
#include "turnscale/rescale/scale_estimator.h"
#include "turnscale/rescale/stretch.h"
#include "turnscale/rescale/sway_step.h"

namespace turnscale {

struct RescaleOptions {
  CarPrior car;
  /// The paper's Q; found from the trajectory (FindCameraMount) where it is not given. What it has wrong in yaw is
  /// found in either case, its pitch does not matter (SwayStep), and of the roll some degrees do little.
  std::optional<Eigen::Quaterniond> vehicle_from_camera;
  /// The poses' times are seconds. Without them there is no speed, and the tyres are taken not to slip.
  bool timed = true;
  KeySpacingOptions keys;
  StretchOptions stretches;
  ScaleEstimatorOptions estimator;
  /// Relative standard deviation that all turns of a drive share and no number of them averages out: of the tape, and
  /// of what the model leaves. KITTI's sequences, one car, want lever arms that differ by this much.
  double lever_arm_sigma = 0.02;
  /// A drive whose best known scale is worse than this (relative) has none.
  double max_scale_sigma = 0.15;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The unit of length at one pose.
struct PoseScale {
  double metres_per_unit = 0;       ///< from the whole drive
  double sigma = 0;                 ///< relative
  double live_metres_per_unit = 0;  ///< from the stretches that had ended by then; 0 up to the first turn
  double live_sigma = 0;
};

struct RescaledTurn {
  int first_pose = 0;
  int last_pose = 0;
  double angle = 0;                ///< rad, positive to the right
  double speed = 0;                ///< m/s; 0 where times are unknown
  double metres_per_unit = 0;      ///< that this turn shows alone; 0 where it contradicts the model
  double sigma = 0;                ///< of that, relative
  double smoothed = 0;             ///< metres per unit from the whole drive
  double smoothed_sigma = 0;       ///< relative
  double effective_lever_arm = 0;  ///< seen at the smoothed scale, metres
  bool used = false;               ///< false where it is too fast: side slip leaves too little of the lever arm
  double weight = 0;               ///< about 1; well below for a turn that disagrees with the rest
};

struct RescaleResult {
  bool observable = false;
  std::string reason;            ///< why there is no scale; one line, empty where there is one
  Trajectory metric;             ///< metres; the first pose keeps its direction from the origin
  std::vector<PoseScale> poses;  ///< one a pose
  std::vector<RescaledTurn> turns;
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();  ///< Q as given or found
  int key_spacing = 0;                                                      ///< poses from key to key
  double length = 0;  ///< of the metric path along its keys, metres
  // What the drive says of the car, with standard deviations.
  double yaw_error = 0;  ///< what Q has too little, rad: the true camera looks so much further right
  double yaw_error_sigma = 0;
  double side_slip = 0;
  double side_slip_sigma = 0;
  double height = 0;  ///< of the camera above the body's roll axis, metres
  double height_sigma = 0;
  ScaleNoise noise;
  double sway_sigma = 0;  ///< of a step's sideways motion, metres
};

/// Gives a trajectory of arbitrary scale its metres, from the turns it makes: no images. Poses are the camera's in any
/// fixed world frame, in the order of time; keyframes only or every frame. Time and memory are linear in the poses.
///
/// Where the drive does not show its scale, `observable` is false, `reason` says why, and nothing is invented. Throws
/// InputError where the trajectory has fewer than two poses, a pose is not finite, times do not increase, or an option
/// makes no sense.
RescaleResult RescaleTrajectory(const RescaleOptions& options, const Trajectory& trajectory);

}  // namespace turnscale
