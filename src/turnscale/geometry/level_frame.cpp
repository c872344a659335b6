// SPDX-License-Identifier: MIT
#include "turnscale/geometry/level_frame.h"

#include <cmath>

namespace turnscale {
namespace {

constexpr double kLeast = 1e-6;

// What the car has above it on the mean over the drive, in the world's axes.
Eigen::Vector3d UpOf(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Vector3d down_in_camera = vehicle_from_camera.conjugate() * Eigen::Vector3d::UnitY();
  Eigen::Vector3d down = Eigen::Vector3d::Zero();
  for (const StampedPose& pose : trajectory) down += pose.world_from_camera.rotation * down_in_camera;
  // A car on its side for half of the drive has no mean; its first pose is used then.
  if (down.norm() > kLeast) return -down.normalized();
  return trajectory.front().world_from_camera.rotation * -down_in_camera;
}

}  // namespace

Eigen::Quaterniond LevelFromWorld(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Quaterniond world_from_vehicle =
      trajectory.front().world_from_camera.rotation * vehicle_from_camera.conjugate();
  const Eigen::Vector3d up = UpOf(trajectory, vehicle_from_camera);
  const Eigen::Vector3d forward = world_from_vehicle * Eigen::Vector3d::UnitZ();
  Eigen::Vector3d ahead = forward - forward.dot(up) * up;
  if (ahead.norm() < kLeast) ahead = up.unitOrthogonal();
  ahead.normalize();
  Eigen::Matrix3d level_from_world;
  level_from_world << ahead.cross(up).transpose(), ahead.transpose(), up.transpose();
  return Eigen::Quaterniond(level_from_world);
}

Eigen::Matrix<double, 2, 3> TopViewAxes(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera) {
  constexpr double kAlong = 0.9;
  const Eigen::Vector3d up = UpOf(trajectory, vehicle_from_camera);
  const Eigen::Vector3d reference = std::abs(up.x()) < kAlong ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  Eigen::Matrix<double, 2, 3> axes;
  axes.row(0) = (reference - reference.dot(up) * up).normalized();
  axes.row(1) = up.cross(Eigen::Vector3d(axes.row(0)));
  return axes;
}

}  // namespace turnscale
