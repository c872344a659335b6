// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace turnscale {

/// Rotation and translation between two frames, named `target_from_source`:
/// `x_in_target = target_from_source * x_in_source`.
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  RigidTransform inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation)};
  }
  /// Neither infinite nor NaN in any component.
  bool IsFinite() const { return rotation.coeffs().allFinite() && translation.allFinite(); }
};

inline Eigen::Vector3d operator*(const RigidTransform& target_from_source, const Eigen::Vector3d& x_in_source) {
  return target_from_source.rotation * x_in_source + target_from_source.translation;
}

inline RigidTransform operator*(const RigidTransform& c_from_b, const RigidTransform& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

/// A pose at a time (seconds).
struct StampedPose {
  double time = 0;
  RigidTransform world_from_camera;
};

/// Poses in the order of time; each holds the body's (by default the camera's) pose in one world frame.
using Trajectory = std::vector<StampedPose>;

}  // namespace turnscale
