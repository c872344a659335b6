// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/scale_line.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

constexpr int kMaxIterations = 100;
constexpr double kRelativeTolerance = 1e-14;
constexpr double kMedianPenalty = 1.2533;  // standard deviation of a median over that of a mean

using WeightedValues = std::vector<std::pair<double, double>>;

/// Sums of the weighted estimating equation A l^2 + B l - C = 0; its positive root is the scale l.
struct Sums {
  double A = 0;
  double B = 0;
  double C = 0;

  void Add(const ScaleLinePoint& point, double lever_arm, double weight) {
    A += weight * point.x * point.x * point.slip;
    B += weight * point.x * point.y;
    C += weight * point.x * point.x * lever_arm;
  }
  /// Derivative of the equation by l at its root.
  double Slope() const { return std::sqrt(B * B + 4.0 * A * C); }
  /// 1/l, which passes through 0 where the scale passes through infinity. No cancellation where the slip is small.
  double InverseScale() const { return (B + Slope()) / (2.0 * C); }
};

double Residual(const ScaleLinePoint& point, double lever_arm, double scale) {
  return point.y - (lever_arm / scale - point.slip * scale) * point.x;
}

WeightedValues InverseScales(const std::vector<ScaleLinePoint>& points, double lever_arm) {
  WeightedValues values;
  for (const ScaleLinePoint& point : points) {
    if (point.x == 0) continue;
    Sums sums;
    sums.Add(point, lever_arm, 1.0);
    values.emplace_back(sums.InverseScale(), std::abs(point.x));
  }
  return values;
}

/// Robust standard deviation of the residuals. One parameter was fitted to them: the factor keeps three or four steps
/// from looking better than they are.
double ResidualSpread(const std::vector<ScaleLinePoint>& points, double lever_arm, double scale) {
  std::vector<double> residuals;
  residuals.reserve(points.size());
  for (const ScaleLinePoint& point : points) residuals.push_back(Residual(point, lever_arm, scale));
  const double n = static_cast<double>(points.size());
  return RobustSigma(std::move(residuals)) * std::sqrt(n / std::max(n - 1.0, 1.0));
}

double TukeyWeight(double residual_in_widths) {
  const double inside = 1.0 - residual_in_widths * residual_in_widths;
  return inside > 0 ? inside * inside : 0.0;
}

bool IsScale(double scale) { return std::isfinite(scale) && scale > 0; }

double SigmaOfLine(const std::vector<ScaleLinePoint>& points, const ScaleLine& line, double lever_arm,
                   double noise_floor) {
  Sums sums;
  double weights = 0;
  double scatter = 0;
  double leverage = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = line.weight[i];
    const double r = Residual(points[i], lever_arm, line.scale);
    sums.Add(points[i], lever_arm, w);
    weights += w;
    scatter += w * r * r;
    leverage += w * points[i].x * points[i].x;
  }
  const double variance = weights > 1.0 ? scatter / (weights - 1.0) : 0.0;
  const double noise = std::max(std::sqrt(variance), noise_floor);
  return line.scale * noise * std::sqrt(leverage) / sums.Slope();
}

}  // namespace

ScaleLine FitScaleLine(const std::vector<ScaleLinePoint>& points, double lever_arm, double noise_floor,
                       double robust_threshold) {
  ScaleLine line;
  line.weight.assign(points.size(), 0.0);
  line.scale = 1.0 / WeightedMedian(InverseScales(points, lever_arm));
  if (!IsScale(line.scale)) return line;
  // The width stays as the start gives it: with it fixed, the iteration goes down to one minimum.
  const double spread = std::max(ResidualSpread(points, lever_arm, line.scale), noise_floor);
  const double width = robust_threshold * spread;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    Sums sums;
    for (std::size_t i = 0; i < points.size(); ++i) {
      line.weight[i] = TukeyWeight(Residual(points[i], lever_arm, line.scale) / width);
      sums.Add(points[i], lever_arm, line.weight[i]);
    }
    const double previous = std::exchange(line.scale, 1.0 / sums.InverseScale());
    if (!IsScale(line.scale)) return line;
    if (std::abs(line.scale - previous) <= kRelativeTolerance * previous) break;
  }
  line.sigma = SigmaOfLine(points, line, lever_arm, noise_floor);
  return line;
}

ScaleLine MedianScale(const std::vector<ScaleLinePoint>& points, double lever_arm) {
  WeightedValues inverse_scales = InverseScales(points, lever_arm);
  for (auto& [value, weight] : inverse_scales) weight = 1.0;
  ScaleLine line;
  line.weight.assign(points.size(), 1.0);
  const double median = WeightedMedian(inverse_scales);
  line.scale = 1.0 / median;
  const double n = static_cast<double>(inverse_scales.size());
  for (auto& [value, weight] : inverse_scales) value = std::abs(value - median);
  const double spread = kSigmaPerMad * WeightedMedian(std::move(inverse_scales));
  line.sigma = kMedianPenalty * spread / std::sqrt(n) * line.scale * line.scale;
  return line;
}

}  // namespace turnscale
