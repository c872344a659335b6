// SPDX-License-Identifier: MIT
#include "turnscale/rescale/pooled_sway.h"

#include <algorithm>
#include <cmath>

namespace turnscale {

Eigen::Vector4d SwayRegressors(const SwayStep& step) {
  const double x = 2 * std::sin(0.5 * step.psi);
  return {x, -step.speed * step.speed * x, step.length, step.roll};
}

PooledSway PoolSway(std::span<const SwayStep> steps, const Eigen::Vector4d& coefficients, double sigma, double huber) {
  PooledSway pooled;
  for (const SwayStep& step : steps) {
    if (!step.usable) continue;
    const Eigen::Vector4d regressors = SwayRegressors(step);
    const double residual = std::abs(step.sway - regressors.dot(coefficients)) / sigma;
    const double weight = huber / std::max(residual, huber) / (sigma * sigma);
    pooled.information += weight * regressors * regressors.transpose();
    pooled.target += weight * step.sway * regressors;
    pooled.scatter += weight * step.sway * step.sway;
  }
  return pooled;
}

void AppendResiduals(std::span<const SwayStep> steps, const Eigen::Vector4d& coefficients,
                     std::vector<double>& residuals) {
  for (const SwayStep& step : steps) {
    if (step.usable) residuals.push_back(step.sway - SwayRegressors(step).dot(coefficients));
  }
}

}  // namespace turnscale
