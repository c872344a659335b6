// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_scale.h"

#include "turnscale/geometry/trajectory.h"
#include "turnscale/rescale/rescale.h"

namespace turnscale {
namespace {

// Of the direction of travel, stretch by stretch, rad (0.02 deg): what this odometry has, and less than other
// trajectories are given. In a bend of one radius a direction that is off looks like a longer lever arm, so with more
// room than needed the scale would hang on how turns begin and end.
constexpr NoisePrior kDirectionNoise{0.0002, 0.0008, 0.0004, 0.7};

}  // namespace

std::vector<PoseScale> ScaleKeyframes(const Map& map, const std::vector<double>& unit_at_keyframe,
                                      const MountCalibration& mount, const VehicleOptions& vehicle) {
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
  RescaleOptions options;
  options.vehicle_from_camera = Eigen::Quaterniond::Identity();
  options.car.lever_arm = *vehicle.lever_arm;
  options.car.side_slip = vehicle.side_slip;
  options.car.side_slip_sigma = vehicle.side_slip_sigma;
  options.estimator.noise.direction = kDirectionNoise;
  return RescaleTrajectory(options, path, gaps).poses;
}

}  // namespace turnscale
