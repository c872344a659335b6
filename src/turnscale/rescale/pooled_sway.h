// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "turnscale/rescale/sway_step.h"

namespace turnscale {

/// What a step's sideways motion is made of: sway = regressors . coefficients, with the regressors
///   2 sin(psi/2)          times L/lambda: the camera swings outwards in a turn;
///   -speed^2 2 sin(psi/2) times c lambda: the tyres slip;
///   length                times the direction of travel on a straight: the yaw by which Q is wrong;
///   roll                  times h/lambda: the body leans about an axis h below the camera.
/// The last two are no part of the paper.
Eigen::Vector4d SwayRegressors(const SwayStep& step);

/// Everything that steps say of their coefficients: weighted normal equations, the pooled line of blueprint 3 with
/// four slopes.
struct PooledSway {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  Eigen::Vector4d target = Eigen::Vector4d::Zero();  ///< information * coefficients = target at the minimum
  double scatter = 0;                                ///< the weighted squares at coefficients of zero

  /// Weighted squares of the residuals.
  double Cost(const Eigen::Vector4d& coefficients) const {
    return scatter - 2 * coefficients.dot(target) + coefficients.dot(information * coefficients);
  }
};

/// Pools steps. `sigma` is the sway noise (odometry units, > 0): position noise, of one size for short and long steps.
/// Residuals about `coefficients` beyond `huber` sigmas lose weight (Huber).
PooledSway PoolSway(std::span<const SwayStep> steps, const Eigen::Vector4d& coefficients, double sigma, double huber);

/// What the usable steps' sway is off the coefficients, odometry units.
void AppendResiduals(std::span<const SwayStep> steps, const Eigen::Vector4d& coefficients,
                     std::vector<double>& residuals);

}  // namespace turnscale
