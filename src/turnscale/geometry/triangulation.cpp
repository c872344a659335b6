// SPDX-License-Identifier: MIT
#include "turnscale/geometry/triangulation.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace turnscale {

std::optional<Eigen::Vector3d> Triangulate(std::span<const CameraRay> rays) {
  // Sum of the projectors onto the planes normal to each ray; singular when all rays are parallel.
  Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  if (rays.size() < 2) return std::nullopt;
  // Relative to the first centre, so that far from the origin no digits are lost.
  const Eigen::Vector3d origin = rays.front().camera_from_world.inverse().translation;
  for (const CameraRay& ray : rays) {
    const RigidTransform world_from_camera = ray.camera_from_world.inverse();
    const Eigen::Vector3d direction = (world_from_camera.rotation * ray.direction).normalized();
    const Eigen::Matrix3d projector = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    normal_matrix += projector;
    right_side += projector * (world_from_camera.translation - origin);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal_matrix);
  constexpr double kParallel = 1e-9;
  if (!(eigen.eigenvalues()[0] > kParallel * eigen.eigenvalues()[2])) return std::nullopt;
  const Eigen::Vector3d offset = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                                 eigen.eigenvectors().transpose() * right_side;
  const Eigen::Vector3d point = origin + offset;
  for (const CameraRay& ray : rays)
    if (!((ray.camera_from_world * point).dot(ray.direction) > 0)) return std::nullopt;
  return point;
}

double ParallaxAngle(const RigidTransform& camera_a_from_world, const RigidTransform& camera_b_from_world,
                     const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector3d a = x_in_world - camera_a_from_world.inverse().translation;
  const Eigen::Vector3d b = x_in_world - camera_b_from_world.inverse().translation;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace turnscale
