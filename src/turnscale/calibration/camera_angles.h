// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// Standard deviations of yaw, pitch and roll (rad) from the covariance of the small rotation about vehicle axes that
/// corrects `vehicle_from_camera`. Infinite where anything of it is.
YawPitchRoll SigmaOfAngles(const Eigen::Quaterniond& vehicle_from_camera, const Eigen::Matrix3d& covariance);

/// The covariance of a rotation that is not known: infinite on the diagonal, 0 beside it.
Eigen::Matrix3d UnknownRotation();

/// Q from the two directions that a drive shows in the camera's frame: where it goes on the whole, and the axis, nearly
/// at right angles to it, about which it turns (downwards). Throws nothing; the axis must not be along the way.
Eigen::Quaterniond RotationFromForwardAndDown(const Eigen::Vector3d& forward, const Eigen::Vector3d& down);

}  // namespace turnscale
