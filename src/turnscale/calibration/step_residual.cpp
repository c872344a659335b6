// SPDX-License-Identifier: MIT
#include "turnscale/calibration/step_residual.h"

#include <algorithm>
#include <cmath>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kMaxSine = 0.95;
const double kFrobenius = std::sqrt(8.0);

}  // namespace

double TravelDirection(double psi, double lever_ratio) {
  return 0.5 * psi + std::asin(std::clamp(2 * lever_ratio * std::sin(0.5 * psi), -kMaxSine, kMaxSine));
}

StepResidual EvaluateStep(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera, double psi,
                          double lever_ratio) {
  const Eigen::Quaterniond turn = vehicle_from_camera * step.rotation * vehicle_from_camera.conjugate();
  const double half = 0.5 * psi;
  const double sine = std::sin(half);
  const double cosine = std::cos(half);
  Eigen::Quaterniond off = turn * Eigen::Quaterniond(cosine, 0, -sine, 0);
  if (off.w() < 0) off.coeffs() = -off.coeffs();
  const Eigen::Matrix3d skew = Skew(off.vec());
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();

  StepResidual residual;
  residual.value.head<3>() = kFrobenius * off.vec();
  residual.by_rotation.topRows<3>() =
      0.5 * kFrobenius * (off.w() * identity - skew) * (identity - turn.toRotationMatrix());
  residual.by_psi.head<3>() = -0.5 * kFrobenius * (off.w() * Eigen::Vector3d::UnitY() + skew.col(1));
  residual.by_ratio.head<3>().setZero();

  const double reach = 2 * lever_ratio * sine;
  const double slip_sine = std::clamp(reach, -kMaxSine, kMaxSine);
  const double inner = std::abs(reach) < kMaxSine ? 1 / std::sqrt(1 - slip_sine * slip_sine) : 0;
  const double theta = half + std::asin(slip_sine);
  const Eigen::Vector3d travel = vehicle_from_camera * step.direction;
  const Eigen::Vector3d across(std::cos(theta), 0, -std::sin(theta));
  residual.value.tail<3>() = travel - Eigen::Vector3d(std::sin(theta), 0, std::cos(theta));
  residual.by_rotation.bottomRows<3>() = -Skew(travel);
  residual.by_psi.tail<3>() = -(0.5 + inner * lever_ratio * cosine) * across;
  residual.by_ratio.tail<3>() = -(inner * 2 * sine) * across;
  return residual;
}

}  // namespace turnscale
