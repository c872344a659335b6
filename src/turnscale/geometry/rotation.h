// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "turnscale/geometry/angle.h"

namespace turnscale {

/// Matrix of the cross product: Skew(a) * b = a x b.
Eigen::Matrix3d Skew(const Eigen::Vector3d& v);

/// Rotation by |v| radians about v. Exact to rounding for any |v|, zero included.
Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& v);

/// Rotation vector (radians, norm in [0, pi]) of a unit quaternion; accurate near zero, where arccos of the trace is
/// not.
Eigen::Vector3d VectorFromRotation(const Eigen::Quaterniond& rotation);

/// Angle of a rotation in radians, in [0, pi].
double RotationAngle(const Eigen::Quaterniond& rotation);

/// Rotation about the y axis that is nearest to the given one (swing-twist), in radians, in (-pi, pi].
/// In a frame with y down, positive turns right.
double TwistAboutY(const Eigen::Quaterniond& rotation);

/// Angles of the camera on the car, radians, in axes x right, y down, z forward:
/// R = R_y(yaw) R_x(pitch) R_z(roll). Yaw > 0 looks right, pitch > 0 looks up, roll > 0 leans right.
/// These are the z-y-x Euler angles of the automotive frame forward-right-down.
struct YawPitchRoll {
  double yaw = 0;
  double pitch = 0;
  double roll = 0;
};

Eigen::Quaterniond RotationFromYawPitchRoll(const YawPitchRoll& angles);

/// Inverse of RotationFromYawPitchRoll; pitch in [-pi/2, pi/2].
YawPitchRoll YawPitchRollFromRotation(const Eigen::Quaterniond& rotation);

/// Rotation that takes `first` directions onto `second` ones best, robustly: the sum of the angles (not of their
/// squares) is made small, so that near points, which move by more than the rotation, do not pull it away.
/// Both lists have the same length, at least two; vectors of any length.
Eigen::Quaterniond FitRotation(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second);

}  // namespace turnscale
