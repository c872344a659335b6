// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace turnscale {

/// The value that the larger ones reach half of the sum with: half of a drive's turning happens in steps at least this
/// large, however long the straights between the turns are. 0 for no values; none may be negative.
inline double HalfSumValue(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const double half = 0.5 * std::accumulate(values.begin(), values.end(), 0.0);
  double sum = 0;
  for (const double value : values) {
    sum += value;
    if (sum >= half) return value;
  }
  return 0;
}

/// Standard deviation of residuals about zero, from the median of their sizes: a third of them may be anything.
inline double RobustSigma(std::vector<double> residuals) {
  constexpr double kSigmaPerMad = 1.4826;  // of a normal distribution
  if (residuals.empty()) return 0;
  for (double& residual : residuals) residual = std::abs(residual);
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
  std::nth_element(residuals.begin(), middle, residuals.end());
  return kSigmaPerMad * *middle;
}

}  // namespace turnscale
