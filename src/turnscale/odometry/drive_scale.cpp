// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_scale.h"

#include <algorithm>
#include <utility>

#include "turnscale/geometry/trajectory.h"
#include "turnscale/rescale/rescale.h"

namespace turnscale {
namespace {

// Of the direction of travel, stretch by stretch, rad (0.02 deg): what this odometry has, and less than other
// trajectories are given. Between 0.02 and 0.07 deg it moves the length of the recorded drives by half a per cent. In a
// bend of one radius a direction that is off looks like a longer lever arm, so with more room than needed the scale
// would hang on how turns begin and end.
constexpr NoisePrior kDirectionNoise{0.0002, 0.0008, 0.0004, 0.7};

}  // namespace

std::optional<DriveScale> DriveScaleOf(const Map& map, const std::vector<double>& unit_at_keyframe,
                                       const MountCalibration& mount, const OdometryOptions& options) {
  const VehicleOptions& vehicle = options.vehicle;
  if (map.keyframes.size() < 2 || !vehicle.lever_arm) return {};
  Trajectory path;
  std::vector<int> gaps;
  RigidTransform last;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (int k = 0; k < static_cast<int>(map.keyframes.size()); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    const RigidTransform pose = keyframe.camera_from_world.inverse();
    if (k > 0) place += (pose.translation - last.translation) / unit_at_keyframe[k];
    if (k > 0 && keyframe.after_gap) gaps.push_back(k);
    // The axes are the vehicle's, since the camera may have been moved on the way.
    path.push_back({keyframe.time, {pose.rotation * mount.At(k).conjugate(), place}});
    last = pose;
  }
  // One keyframe that went astray leaves nothing to be smoothed; the drive goes on with what its turns say.
  const auto finite = [](const StampedPose& pose) {
    return pose.world_from_camera.translation.allFinite() && pose.world_from_camera.rotation.coeffs().allFinite();
  };
  if (!std::all_of(path.begin(), path.end(), finite)) return {};
  RescaleOptions rescale;
  rescale.vehicle_from_camera = Eigen::Quaterniond::Identity();
  rescale.car.lever_arm = *vehicle.lever_arm;
  rescale.car.side_slip = vehicle.side_slip;
  rescale.car.side_slip_sigma = vehicle.side_slip_sigma;
  rescale.estimator.noise.direction = kDirectionNoise;
  rescale.estimator.gap_sigma = options.scale.gap_sigma;
  RescaleResult result = RescaleTrajectory(rescale, path, gaps);
  if (!result.observable) return {};
  return DriveScale{
      std::move(result.poses),
      {result.yaw_error, result.yaw_error_sigma, result.side_slip, result.side_slip_sigma, result.side_slip_at_bound}};
}

}  // namespace turnscale
