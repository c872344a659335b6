// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/robust_line.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

constexpr int kMaxIterations = 100;
constexpr double kRelativeTolerance = 1e-14;

// The slope that minimises the sum of absolute residuals.
double MedianSlope(const std::vector<LinePoint>& points) {
  std::vector<std::pair<double, double>> slopes;
  for (const LinePoint& point : points)
    if (point.x != 0) slopes.emplace_back(point.y / point.x, std::abs(point.x));
  return WeightedMedian(std::move(slopes));
}

// Robust standard deviation of the residuals. One parameter was fitted to them: the factor keeps three or four points
// from looking better than they are.
double ResidualSpread(const std::vector<LinePoint>& points, double slope) {
  std::vector<double> residuals;
  residuals.reserve(points.size());
  for (const LinePoint& point : points) residuals.push_back(point.y - slope * point.x);
  const double n = static_cast<double>(points.size());
  return RobustSigma(std::move(residuals)) * std::sqrt(n / std::max(n - 1.0, 1.0));
}

double TukeyWeight(double residual_in_widths) {
  const double inside = 1.0 - residual_in_widths * residual_in_widths;
  return inside > 0 ? inside * inside : 0.0;
}

double SigmaOfSlope(const std::vector<LinePoint>& points, const RobustLine& line, double noise_floor) {
  double weights = 0;
  double scatter = 0;
  double leverage = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = line.weight[i];
    const double residual = points[i].y - line.slope * points[i].x;
    weights += w;
    scatter += w * residual * residual;
    leverage += w * points[i].x * points[i].x;
  }
  const double variance = weights > 1.0 ? scatter / (weights - 1.0) : 0.0;
  return std::max(std::sqrt(variance), noise_floor) / std::sqrt(leverage);
}

}  // namespace

RobustLine FitRobustLine(const std::vector<LinePoint>& points, double noise_floor, double threshold) {
  RobustLine line;
  line.weight.assign(points.size(), 0.0);
  line.slope = MedianSlope(points);
  // The width stays as the start gives it: with it fixed, the iteration goes down to one minimum.
  const double width = threshold * std::max(ResidualSpread(points, line.slope), noise_floor);
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    double xy = 0;
    double xx = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto& [x, y] = points[i];
      line.weight[i] = TukeyWeight((y - line.slope * x) / width);
      xy += line.weight[i] * x * y;
      xx += line.weight[i] * x * x;
    }
    const double previous = std::exchange(line.slope, xy / xx);
    if (std::abs(line.slope - previous) <= kRelativeTolerance * std::abs(previous)) break;
  }
  line.sigma = SigmaOfSlope(points, line, noise_floor);
  return line;
}

}  // namespace turnscale
