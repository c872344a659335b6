// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/kinematics/step_height.h"
#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// The camera-to-vehicle rotation, as a path shows it.
struct MountFromPath {
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();  ///< the paper's Q
  /// Standard deviation of its yaw as turns show it, rad. Empty where they do not: the camera is then taken as upright
  /// and looking along the mean direction of travel.
  std::optional<double> yaw_sigma;
};

/// The paper's Q from the path itself, whichever way its body's axes lie. `timed` says that the poses' times are
/// seconds, `gaps` which poses do not hang together with the one before (increasing). Motion between poses that are too
/// far apart for `options` is left out, as it is for the scale.
///
/// Throws InputError where the path has no direction of travel, or is too short to tell.
MountFromPath FindCameraMount(const Trajectory& trajectory, bool timed, const std::vector<int>& gaps = {},
                              const VehicleStepOptions& options = {});

struct RescaleOptions {
  CarPrior car;
  /// The paper's Q; estimated from the trajectory (FindCameraMount) if not given. Its yaw error is estimated in either
  /// case; its pitch does not matter (LevelStep), and some degrees of roll have little effect.
  std::optional<Eigen::Quaterniond> vehicle_from_camera;
  /// The poses' times are seconds. Without times there is no speed, and slip takes `untimed_slip` of the lever arm,
  /// whatever c the car has, unless it is rigid (CarPrior::is_rigid).
  bool timed = true;
  /// Share of the lever arm that slip takes in turns of unknown speed, and its standard deviation: 6 to 24 % in streets
  /// (KITTI), next to nothing in a garage.
  double untimed_slip = 0.1;
  double untimed_slip_sigma = 0.08;
  /// The scale drifts along the drive; false for loop-closed inputs, whose scale is constant.
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
  bool from_road = false;  ///< no turn that is used, and the heights show the scale of the step that leads to the pose
  /// From the steps up to the pose; 0 until the scale is known.
  double filtered_metres_per_unit = 0;
  double filtered_sigma = 0;
};

/// c, s^2/m.
struct SideSlip {
  double value = 0;
  double sigma = 0;
};

struct RescaleResult {
  bool observable = false;
  std::string reason;               ///< why there is no scale; one line, empty if there is one
  Trajectory metric;                ///< metres; the first pose keeps its direction from the origin
  std::vector<RescaledPose> poses;  ///< one per pose
  std::vector<VehicleStep> steps;   ///< that the estimate's turns refer to
  std::optional<ScaleEstimate> estimate;
  /// Q as given or estimated.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  double yaw_sigma = 0;  ///< standard deviation of its yaw, rad, before the turns refine it
  /// As assumed before the drive; empty without times, where slip is a share of the lever arm.
  std::optional<SideSlip> assumed_slip;
  /// Of the metric path along its steps, metres; without jumps and gaps.
  double length = 0;
  /// Of the way across the gaps, metres, which is not measured.
  double gap_length = 0;
};

/// Converts an up-to-scale trajectory to metres, with the scale estimated from its turns: no images. Poses are the
/// camera's in any fixed world frame, in the order of time; keyframes only or every frame. `gaps` are poses before
/// which tracking was lost, in order: steps do not extend across, and the scale may jump; if the poses have
/// times, the metric way across is that at the mean of the speeds before and after. `heights` above the road, in
/// the order of time, show the scale between turns, and without a turn where the car's is known; those at times beyond
/// the poses are left out. They need poses with times. Time and memory are linear.
///
/// If the scale is not observable, `observable` is false and `reason` says why. Throws
/// InputError if the trajectory has fewer than two poses, a pose is not finite, times or gaps do not increase, a height
/// makes no sense or the poses have no times for it, or an option is invalid.
RescaleResult RescaleTrajectory(const RescaleOptions& options, const Trajectory& trajectory,
                                const std::vector<PathGap>& gaps = {}, const std::vector<PathHeight>& heights = {});

}  // namespace turnscale
