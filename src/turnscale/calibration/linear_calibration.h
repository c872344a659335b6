// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// The axis that a car's camera turns about, downwards in the camera's frame: the direction that all rotations of a
/// drive share. From it comes the sign of the turning angle, one for the whole drive where the paper takes it frame by
/// frame. Motion alone cannot distinguish a camera from one that hangs upside down (both axes of the car's level plane
/// reversed), so the camera is assumed to be less than a quarter turn from upright: its y axis points downwards.
class TurningAxis {
 public:
  void Add(const Eigen::Quaterniond& previous_from_current);

  /// Unit vector; the camera's y axis while nothing has turned.
  const Eigen::Vector3d& direction() const { return direction_; }

 private:
  Eigen::Matrix3d scatter_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d direction_ = Eigen::Vector3d::UnitY();
};

/// psi of (8), (9), rad: the whole angle of the rotation, by atan2 since the arccos of (9) loses half the digits near
/// zero, positive where the rotation goes about `axis`.
double TurningAngle(const Eigen::Quaterniond& previous_from_current, const Eigen::Vector3d& axis);

/// Solution of (14).
struct LinearSolution {
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();  ///< the paper's Q
  Eigen::Vector4d singular_values = Eigen::Vector4d::Zero();                ///< of M, smallest first
  /// Ratio of the two smallest singular values: near 1 if a whole family of rotations fits equally well.
  double confidence = 1;
};

/// The linear solution (9)-(14), one step at a time: of the tall matrix M only the small M^T M is kept.
class LinearCalibration {
 public:
  /// Takes `previous_from_current` and its turning angle psi, rad. A step of length 0 contributes its rotation only.
  void Add(const RigidTransform& motion, double psi);

  LinearSolution Solve() const;

 private:
  Eigen::Matrix4d gram_ = Eigen::Matrix4d::Zero();
};

}  // namespace turnscale
