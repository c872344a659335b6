// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

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
  /// Takes `previous_from_current` and its turning angle psi, rad. A step of length 0 tells of its rotation only.
  void Add(const RigidTransform& motion, double psi);

  LinearSolution Solve() const;

 private:
  Eigen::Matrix4d gram_ = Eigen::Matrix4d::Zero();
};

}  // namespace turnscale
