// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// A ray in a camera: direction (any length) in the camera frame and the camera's pose.
struct CameraRay {
  RigidTransform camera_from_world;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< in the camera frame
};

/// Point of the world nearest to all rays (least squares of the distances); needs two rays that are not parallel.
/// Empty where the point is not determined or lies behind one of the cameras.
std::optional<Eigen::Vector3d> Triangulate(std::span<const CameraRay> rays);

/// Angle in radians at which two camera centres are seen from a point of the world.
double ParallaxAngle(const RigidTransform& camera_a_from_world, const RigidTransform& camera_b_from_world,
                     const Eigen::Vector3d& x_in_world);

}  // namespace turnscale
