// SPDX-License-Identifier: MIT
#include "turnscale/calibration/linear_calibration.h"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Omega_r(camera) - Omega_l(vehicle) of (12): half of a row of (14).
Eigen::Matrix4d ProductDifference(const Eigen::Quaterniond& camera, const Eigen::Quaterniond& vehicle) {
  const Eigen::Vector3d difference = camera.vec() - vehicle.vec();
  Eigen::Matrix4d m;
  m << 0, -difference.transpose(), difference, -Skew(camera.vec() + vehicle.vec());
  m += (camera.w() - vehicle.w()) * Eigen::Matrix4d::Identity();
  return m;
}

Eigen::Quaterniond Pure(const Eigen::Vector3d& v) { return {0, v.x(), v.y(), v.z()}; }

}  // namespace

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

void LinearCalibration::Add(const RigidTransform& motion, double psi) {
  Eigen::Quaterniond rotation = motion.rotation;
  if (rotation.w() < 0) rotation.coeffs() = -rotation.coeffs();
  const Eigen::Matrix4d turn = ProductDifference(rotation, RotationFromVector({0, psi, 0}));
  gram_ += turn.transpose() * turn;
  const double length = motion.translation.norm();
  if (length <= 0) return;
  const Eigen::Vector3d direction = motion.translation / length;
  // (13), the lever arm taken as 0.
  const Eigen::Matrix4d travel =
      ProductDifference(Pure(direction), Pure({std::sin(0.5 * psi), 0, std::cos(0.5 * psi)}));
  gram_ += travel.transpose() * travel;
}

LinearSolution LinearCalibration::Solve() const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(gram_);
  LinearSolution solution;
  solution.singular_values = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  const Eigen::Vector4d q = solver.eigenvectors().col(0);
  solution.vehicle_from_camera = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  const double least = solution.singular_values[0];
  const double next = solution.singular_values[1];
  // Eigenvalues below the rounding of M^T M are equal.
  const double rounding = 1e-8 * solution.singular_values[3];
  if (next > rounding) solution.confidence = next / std::max(least, rounding);
  return solution;
}

}  // namespace turnscale
