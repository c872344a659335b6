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
  Eigen::Matrix<double, 4, 2> by_effects = Eigen::Matrix<double, 4, 2>::Zero();
  by_effects(0, 0) = coefficients[0];
  by_effects(2, 1) = 1;

  const Eigen::Vector4d slope = pooled.target - pooled.information * coefficients;
  const Eigen::Vector2d effects_prior(observation.lever_weight / (noise.lever * noise.lever),
                                      observation.direction_weight / (noise.direction * noise.direction));
  ScaleEvidence evidence;
  evidence.effects_gradient = by_effects.transpose() * slope;
  evidence.effects_by_state = by_effects.transpose() * pooled.information * by_state;
  Eigen::Matrix2d effects_information = by_effects.transpose() * pooled.information * by_effects;
  effects_information.diagonal() += effects_prior;
  evidence.effects_covariance = effects_information.inverse();
  const Eigen::Matrix<double, 4, 2> gain = evidence.effects_by_state.transpose() * evidence.effects_covariance;
  evidence.information = by_state.transpose() * pooled.information * by_state - gain * evidence.effects_by_state;
  evidence.gradient = by_state.transpose() * slope - gain * evidence.effects_gradient;
  evidence.cost = pooled.Cost(coefficients) -
                  evidence.effects_gradient.dot(evidence.effects_covariance * evidence.effects_gradient) +
                  std::log(effects_information.determinant() / effects_prior.prod());
  return evidence;
}

RandomEffects RandomEffectsOf(const ScaleEvidence& evidence, const DriveState& taken_at, const Belief& belief) {
  const Eigen::Matrix<double, 2, 4> by_state = evidence.effects_covariance * evidence.effects_by_state;
  const Eigen::Matrix2d covariance = evidence.effects_covariance + by_state * belief.covariance * by_state.transpose();
  return {evidence.effects_covariance * evidence.effects_gradient - by_state * (belief.mean - taken_at),
          covariance.diagonal()};
}

double MeanSquareSpeed(const PooledSway& pooled) {
  return pooled.information(0, 0) > 0 ? -pooled.information(0, 1) / pooled.information(0, 0) : 0;
}

double LeverArmRatio(const PooledSway& pooled, const DriveState& state, double lever_arm) {
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
