// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/trajectory.h"
#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

struct RescaleOptions {
  CarPrior car;
  /// The paper's Q; found from the trajectory (FindCameraMount) where it is not given. What it has wrong in yaw is
  /// estimated in either case, its pitch does not matter (LevelStep), and some degrees of roll do little.
  std::optional<Eigen::Quaterniond> vehicle_from_camera;
  /// The poses' times are seconds. Without them there is no speed, and the tyres are taken not to slip.
  bool timed = true;
  /// The odometry's scale drifts along the drive; false for loop-closed inputs, whose scale is one.
  bool drifting = true;
  VehicleStepOptions steps;
  ScaleEstimatorOptions estimator;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The unit of length at one pose.
struct RescaledPose {
  double metres_per_unit = 0;  ///< from the whole drive (smoothed)
  double sigma = 0;            ///< relative
  /// From the steps up to the pose; 0 until the scale is known.
  double filtered_metres_per_unit = 0;
  double filtered_sigma = 0;
};

struct RescaleResult {
  bool observable = false;
  std::string reason;               ///< why there is no scale; one line, empty where there is one
  Trajectory metric;                ///< metres; the first pose keeps its direction from the origin
  std::vector<RescaledPose> poses;  ///< one a pose
  std::vector<VehicleStep> steps;   ///< that the estimate's turns refer to
  std::optional<ScaleEstimate> estimate;
  /// Q as given or found.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  double yaw_sigma = 0;  ///< standard deviation of its yaw, rad, before the turns refine it
  /// Of the metric path along its steps, metres; without jumps and gaps.
  double length = 0;
};

/// Gives a trajectory of arbitrary scale its metres, from the turns it makes: no images. Poses are the camera's in any
/// fixed world frame, in the order of time; keyframes only or every frame. `gaps` are poses before which tracking was
/// lost, in their order: nothing is read across, and the scale may jump there. Time and memory are linear in the poses.
///
/// Where the drive does not show its scale, `observable` is false, `reason` says why, and nothing is invented. Throws
/// InputError where the trajectory has fewer than two poses, a pose is not finite, times or gaps do not increase, or an
/// option makes no sense.
RescaleResult RescaleTrajectory(const RescaleOptions& options, const Trajectory& trajectory,
                                const std::vector<PathGap>& gaps = {});

}  // namespace turnscale
