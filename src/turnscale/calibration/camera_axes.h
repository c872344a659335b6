// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "turnscale/calibration/camera_step.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// Axis convention of a trajectory's poses.
enum class AxisConvention {
  kCamera,            ///< x right, y down, z forward, or as far from that as a camera may be turned
  kForwardLeftUp,     ///< of a robot's or vehicle's body
  kForwardRightDown,  ///< of an aircraft's or vehicle's body
};

/// Tells a camera from a body: a camera does not turn about its viewing axis when the car turns, a body turns about its
/// z axis and goes along its x axis. While nothing turns, what goes along its x axis is a body.
///
/// Gives kCamera or kForwardLeftUp. Motion does not tell the two bodies apart, no more than a camera from one that
/// hangs upside down: with the other body, yaw and pitch have the other sign, and right turns are left ones.
AxisConvention FindAxisConvention(const std::vector<CameraStep>& steps);

/// The rotation of a camera on a body that looks along its x axis and is level; identity for a camera.
Eigen::Quaterniond BodyFromCamera(AxisConvention axes);

/// The path of a camera on the body that looks along its x axis and is level. A camera's path stays what it is.
Trajectory InCameraAxes(Trajectory body_path, AxisConvention axes);

/// Standard deviations of yaw, pitch and roll (rad) from the covariance of the small rotation about vehicle axes that
/// corrects `vehicle_from_camera`. Infinite where anything of it is.
YawPitchRoll SigmaOfAngles(const Eigen::Quaterniond& vehicle_from_camera, const Eigen::Matrix3d& covariance);

/// The covariance of a rotation that is not known: infinite on the diagonal, 0 beside it.
Eigen::Matrix3d UnknownRotation();

/// Q from the two directions that a drive shows in the camera's frame: where it goes on the whole, and the axis, nearly
/// at right angles to it, about which it turns (downwards). Throws nothing; the axis must not be along the way.
Eigen::Quaterniond RotationFromForwardAndDown(const Eigen::Vector3d& forward, const Eigen::Vector3d& down);

}  // namespace turnscale
