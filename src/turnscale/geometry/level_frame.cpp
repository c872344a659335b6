// SPDX-License-Identifier: MIT
#include "turnscale/geometry/level_frame.h"

namespace turnscale {

Eigen::Quaterniond LevelFromWorld(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Quaterniond camera_from_vehicle = vehicle_from_camera.conjugate();
  Eigen::Vector3d down = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : trajectory)
    down += pose.world_from_camera.rotation * (camera_from_vehicle * Eigen::Vector3d::UnitY());
  const Eigen::Quaterniond world_from_vehicle = trajectory.front().world_from_camera.rotation * camera_from_vehicle;
  // A car on its side for half of the drive has no mean; its first pose is used then.
  constexpr double kLeast = 1e-6;
  const Eigen::Vector3d up =
      down.norm() > kLeast ? Eigen::Vector3d(-down.normalized()) : world_from_vehicle * -Eigen::Vector3d::UnitY();
  const Eigen::Vector3d forward = world_from_vehicle * Eigen::Vector3d::UnitZ();
  Eigen::Vector3d ahead = forward - forward.dot(up) * up;
  if (ahead.norm() < kLeast) ahead = up.unitOrthogonal();
  ahead.normalize();
  Eigen::Matrix3d level_from_world;
  level_from_world << ahead.cross(up).transpose(), ahead.transpose(), up.transpose();
  return Eigen::Quaterniond(level_from_world);
}

}  // namespace turnscale
