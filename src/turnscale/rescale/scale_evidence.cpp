// SPDX-License-Identifier: MIT
#include "turnscale/rescale/scale_evidence.h"

#include <cmath>

#include <Eigen/LU>

namespace turnscale {

Eigen::Vector4d SwayCoefficients(const DriveState& state, double lever_arm) {
  const double units = std::exp(-state[kLogScale]);
  return {lever_arm * units, state[kSlip] / units, state[kTravel], state[kHeight] * units};
}

Eigen::Matrix4d SwayCoefficientsJacobian(const DriveState& state, double lever_arm) {
  const double units = std::exp(-state[kLogScale]);
  Eigen::Matrix4d jacobian = Eigen::Matrix4d::Zero();
  jacobian.col(kLogScale) << -lever_arm * units, state[kSlip] / units, 0, -state[kHeight] * units;
  jacobian(1, kSlip) = 1 / units;
  jacobian(2, kTravel) = 1;
  jacobian(3, kHeight) = units;
  return jacobian;
}

ScaleEvidence EvidenceAt(const StretchObservation& observation, const DriveState& state, double lever_arm,
                         const StretchNoise& noise) {
  const PooledSway& pooled = observation.pooled;
  const Eigen::Vector4d coefficients = SwayCoefficients(state, lever_arm);
  Eigen::Matrix4d by_state = SwayCoefficientsJacobian(state, lever_arm);
  if (!observation.turning) by_state.col(kLogScale).setZero();
  Eigen::Matrix<double, 4, 2> by_own = Eigen::Matrix<double, 4, 2>::Zero();
  by_own(0, 0) = coefficients[0];
  by_own(2, 1) = 1;

  const Eigen::Vector4d slope = pooled.target - pooled.information * coefficients;
  const Eigen::Vector2d own_prior(observation.lever_weight / (noise.lever * noise.lever),
                                  observation.direction_weight / (noise.direction * noise.direction));
  ScaleEvidence evidence;
  evidence.own_gradient = by_own.transpose() * slope;
  evidence.own_by_state = by_own.transpose() * pooled.information * by_state;
  Eigen::Matrix2d own_information = by_own.transpose() * pooled.information * by_own;
  own_information.diagonal() += own_prior;
  evidence.own_covariance = own_information.inverse();
  const Eigen::Matrix<double, 4, 2> gain = evidence.own_by_state.transpose() * evidence.own_covariance;
  evidence.information = by_state.transpose() * pooled.information * by_state - gain * evidence.own_by_state;
  evidence.gradient = by_state.transpose() * slope - gain * evidence.own_gradient;
  evidence.cost = pooled.Cost(coefficients) -
                  evidence.own_gradient.dot(evidence.own_covariance * evidence.own_gradient) +
                  std::log(own_information.determinant() / own_prior.prod());
  return evidence;
}

OwnErrors OwnErrorsOf(const ScaleEvidence& evidence, const DriveState& taken_at, const Belief& belief) {
  const Eigen::Matrix<double, 2, 4> by_state = evidence.own_covariance * evidence.own_by_state;
  const Eigen::Matrix2d covariance = evidence.own_covariance + by_state * belief.covariance * by_state.transpose();
  return {evidence.own_covariance * evidence.own_gradient - by_state * (belief.mean - taken_at), covariance.diagonal()};
}

double MeanSquareSpeed(const PooledSway& pooled) {
  return pooled.information(0, 0) > 0 ? -pooled.information(0, 1) / pooled.information(0, 0) : 0;
}

double LeverShare(const PooledSway& pooled, const DriveState& state, double lever_arm) {
  return 1 - state[kSlip] * MeanSquareSpeed(pooled) * std::exp(2 * state[kLogScale]) / lever_arm;
}

std::optional<double> ScaleOfStretch(const PooledSway& pooled, const DriveState& state, double lever_arm) {
  // The first normal equation, for the units in a metre: quadratic u^2 - linear u - constant = 0.
  const Eigen::Matrix4d& information = pooled.information;
  const double quadratic = information(0, 0) * lever_arm + information(0, 3) * state[kHeight];
  const double linear = pooled.target[0] - information(0, 2) * state[kTravel];
  const double constant = -information(0, 1) * state[kSlip];
  if (!(quadratic > 0)) return std::nullopt;
  const double units = (linear + std::sqrt(linear * linear + 4 * quadratic * constant)) / (2 * quadratic);
  const double scale = 1 / units;
  return std::isfinite(scale) && scale > 0 ? std::optional(scale) : std::nullopt;
}

}  // namespace turnscale
