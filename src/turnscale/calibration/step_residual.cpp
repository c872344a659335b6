// SPDX-License-Identifier: MIT
#include "turnscale/calibration/step_residual.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kMaxSine = 0.95;
const double kFrobenius = std::sqrt(8.0);

constexpr double kMaxLeverRatio = 20;
constexpr int kFits = 4;

using Matrix6d = Eigen::Matrix<double, 6, 6>;

Matrix6d Metric(const StepState& state, bool curvature) {
  Matrix6d metric = state.huber * Matrix6d::Identity();
  if (curvature && state.huber < 1) {
    const StepResidual::Vector along = state.residual.value.normalized();
    metric -= state.huber * along * along.transpose();
  }
  return metric;
}

StepResidual WeightedResidual(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera,
                              const StepWeights& weights, double psi, double lever_ratio) {
  StepResidual residual = EvaluateStep(step, vehicle_from_camera, psi, lever_ratio);
  Whiten(weights, residual);
  return residual;
}

// A curvature's inverse, 0 where there is none to speak of.
double SafeInverse(double value) { return value > 1e-12 ? 1 / value : 0; }

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

ModelResidual ResidualOfModel(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera,
                              double lever_ratio) {
  const Eigen::Vector3d turn = vehicle_from_camera * VectorFromRotation(step.rotation);
  const Eigen::Vector3d travel = vehicle_from_camera * step.direction;
  const double psi = turn.y();
  return {turn.x(), turn.z(), -travel.y(), std::atan2(travel.x(), travel.z()) - TravelDirection(psi, lever_ratio),
          0.5 + lever_ratio};
}

void Whiten(const StepWeights& weights, StepResidual& residual) {
  residual.value = weights.cwiseProduct(residual.value).eval();
  residual.by_rotation = (weights.asDiagonal() * residual.by_rotation).eval();
  residual.by_psi = weights.cwiseProduct(residual.by_psi).eval();
  residual.by_ratio = weights.cwiseProduct(residual.by_ratio).eval();
}

void FitTurningAngle(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera,
                     const StepWeights& weights, StepState& state) {
  state.psi = (vehicle_from_camera * VectorFromRotation(step.rotation)).y();
  for (int i = 0; i < kFits; ++i) {
    const StepResidual residual = WeightedResidual(step, vehicle_from_camera, weights, state.psi, state.lever_ratio);
    const double change = -residual.by_psi.dot(residual.value) / residual.by_psi.squaredNorm();
    state.psi += change;
    if (std::abs(change) < 1e-10) break;
  }
}

void FitFreeStep(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera, const StepWeights& weights,
                 StepState& state) {
  const double psi = (vehicle_from_camera * VectorFromRotation(step.rotation)).y();
  const Eigen::Vector3d travel = vehicle_from_camera * step.direction;
  // With psi as measured, the lever_ratio that explains the direction, if any does.
  const double sine = 2 * std::sin(0.5 * psi);
  const double wanted = std::sin(std::atan2(travel.x(), travel.z()) - 0.5 * psi);
  state.psi = psi;
  state.lever_ratio = std::abs(sine) > 0 ? wanted / sine : 0;
  state.ratio_free = state.lever_ratio > 0 && state.lever_ratio < kMaxLeverRatio;
  if (state.ratio_free) return;
  state.lever_ratio = std::clamp(state.lever_ratio, 0.0, kMaxLeverRatio);
  FitTurningAngle(step, vehicle_from_camera, weights, state);
}

EliminatedStep EliminateTurningAngle(const StepState& state, double per_lever_arm, bool curvature) {
  const StepResidual& residual = state.residual;
  const Matrix6d metric = Metric(state, curvature);
  Eigen::Matrix<double, 6, 4> jacobian;
  jacobian << residual.by_rotation, per_lever_arm * residual.by_ratio;
  const StepResidual::Vector by_psi = metric * residual.by_psi;
  const double inverse = SafeInverse(residual.by_psi.dot(by_psi));
  const Eigen::Vector4d cross = jacobian.transpose() * by_psi;
  EliminatedStep step;
  step.hessian = jacobian.transpose() * metric * jacobian - inverse * cross * cross.transpose();
  // psi is at its best, so nothing of the gradient comes from it.
  step.gradient = state.huber * jacobian.transpose() * residual.value;
  return step;
}

EliminatedStep EliminateFreeStep(const StepState& state, bool curvature) {
  if (!state.ratio_free) return EliminateTurningAngle(state, 0, curvature);
  const StepResidual& residual = state.residual;
  const Matrix6d metric = Metric(state, curvature);
  Eigen::Matrix<double, 6, 2> own;
  own << residual.by_psi, residual.by_ratio;
  const Eigen::Matrix2d own_hessian = own.transpose() * metric * own;
  const Eigen::Matrix<double, 3, 2> cross = residual.by_rotation.transpose() * metric * own;
  EliminatedStep step;
  step.hessian.topLeftCorner<3, 3>() = residual.by_rotation.transpose() * metric * residual.by_rotation -
                                       cross * own_hessian.fullPivLu().solve(cross.transpose());
  step.gradient.head<3>() = state.huber * residual.by_rotation.transpose() * residual.value;
  return step;
}

}  // namespace turnscale
