// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/trajectory.h"
#include "turnscale/rescale/pose_scale.h"
#include "turnscale/rescale/rescaled_turn.h"
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
  /// of what the model leaves. KITTI's sequences, one car, want lever arms that differ by this much, their noise apart.
  double lever_arm_sigma = 0.025;
  /// A drive whose best known scale is worse than this (relative) has none.
  double max_scale_sigma = 0.15;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

struct RescaleResult {
  bool observable = false;
  std::string reason;            ///< why there is no scale; one line, empty where there is one
  Trajectory metric;             ///< metres; the first pose keeps its direction from the origin
  std::vector<PoseScale> poses;  ///< one a pose
  std::vector<RescaledTurn> turns;
  /// Q as given or found.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  /// Poses from key to key.
  int key_spacing = 0;
  /// Of the metric path along its keys, metres; without jumps, gaps and what was not driven forward.
  double length = 0;
  bool converged = false;  ///< the estimate had settled when its iterations ended
  // What the drive says of the car, with standard deviations.
  double yaw_error = 0;  ///< what Q has too little, rad: the true camera looks so much further right
  double yaw_error_sigma = 0;
  double side_slip = 0;
  double side_slip_sigma = 0;       ///< 0 where c was given as known, and without times
  bool side_slip_at_bound = false;  ///< the drive wants tyres that slip inwards: c is held at 0
  double height = 0;                ///< of the camera above the body's roll axis, metres
  double height_sigma = 0;
  ScaleNoise noise;
  double sway_sigma = 0;  ///< of a step's sideways motion, metres
};

/// Gives a trajectory of arbitrary scale its metres, from the turns it makes: no images. Poses are the camera's in any
/// fixed world frame, in the order of time; keyframes only or every frame. `gaps` are poses (by index, increasing)
/// before which tracking was lost: nothing is read across, and the scale may jump there
/// (ScaleEstimatorOptions::gap_sigma). Time and memory are linear in the poses.
///
/// Where the drive does not show its scale, `observable` is false, `reason` says why, and nothing is invented. Throws
/// InputError where the trajectory has fewer than two poses, a pose is not finite, times or gaps do not increase, or an
/// option makes no sense.
RescaleResult RescaleTrajectory(const RescaleOptions& options, const Trajectory& trajectory,
                                const std::vector<int>& gaps = {});

}  // namespace turnscale
