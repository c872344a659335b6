// SPDX-License-Identifier: MIT
#include "turnscale/rescale/scale_start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include <Eigen/QR>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

constexpr int kIterations = 6;
constexpr double kNoLimit = std::numeric_limits<double>::max();

struct RobustLine {
  Eigen::Vector4d coefficients = Eigen::Vector4d::Zero();
  double sigma = 1;
};

RobustLine FitAllSteps(const std::vector<SwayStep>& steps, double huber) {
  RobustLine line;
  const double least_sigma = LeastSwaySigma(steps);
  for (int i = 0; i < kIterations; ++i) {
    const PooledSway pooled = PoolSway(steps, line.coefficients, line.sigma, i == 0 ? kNoLimit : huber);
    line.coefficients = pooled.information.completeOrthogonalDecomposition().solve(pooled.target);
    std::vector<double> residuals;
    AppendResiduals(steps, line.coefficients, residuals);
    line.sigma = std::max(RobustSigma(std::move(residuals)), least_sigma);
  }
  return line;
}

}  // namespace

std::optional<ScaleStart> StartScale(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                     const DriveState& car, double lever_arm, double huber, double min_ratio) {
  const RobustLine line = FitAllSteps(steps, huber);
  DriveState state = car;
  state[kTravel] = line.coefficients[2];
  std::vector<std::pair<double, double>> scales;  // with weights
  for (const Stretch& stretch : stretches) {
    if (!stretch.turning) continue;
    const PooledSway pooled = PoolSway(StepsOf(steps, stretch), line.coefficients, line.sigma, kNoLimit);
    const auto scale = ScaleOfStretch(pooled, state, lever_arm);
    if (!scale) continue;
    state[kLogScale] = std::log(*scale);
    if (LeverArmRatio(pooled, state, lever_arm) < min_ratio) continue;
    scales.emplace_back(state[kLogScale], std::abs(stretch.angle));
  }
  if (scales.empty()) return std::nullopt;
  return ScaleStart{WeightedMedian(std::move(scales)), line.sigma};
}

double LeastSwaySigma(const std::vector<SwayStep>& steps) {
  constexpr double kDirection = 0.0025;  // rad
  double sum = 0;
  for (const SwayStep& step : steps) sum += step.length;
  return steps.empty() ? 0 : kDirection * sum / static_cast<double>(steps.size());
}

}  // namespace turnscale
