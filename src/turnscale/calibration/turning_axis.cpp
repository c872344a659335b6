// SPDX-License-Identifier: MIT
#include "turnscale/calibration/turning_axis.h"

#include <Eigen/Eigenvalues>

#include "turnscale/geometry/rotation.h"

namespace turnscale {

void TurningAxis::Add(const Eigen::Quaterniond& previous_from_current) {
  const Eigen::Vector3d rotation = VectorFromRotation(previous_from_current);
  scatter_ += rotation * rotation.transpose();
  if (scatter_.trace() <= 0) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter_);
  direction_ = solver.eigenvectors().col(2);
  if (direction_.y() < 0) direction_ = -direction_;
}

double TurningAngle(const Eigen::Quaterniond& previous_from_current, const Eigen::Vector3d& axis) {
  const double angle = RotationAngle(previous_from_current);
  return VectorFromRotation(previous_from_current).dot(axis) < 0 ? -angle : angle;
}

}  // namespace turnscale
