// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace turnscale {

/// The value that this share of the values, in [0, 1], lies below: one of them, the upper middle one for 0.5 of an even
/// number. 0 of none.
inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
  const auto place = std::min(static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size())), last);
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

inline double Median(std::vector<double> values) { return Quantile(std::move(values), 0.5); }

/// The value at which the weights of the values up to it, (value, weight), reach half of all weight. 0 of none.
inline double WeightedMedian(std::vector<std::pair<double, double>> values) {
  std::sort(values.begin(), values.end());
  double total = 0;
  for (const auto& [value, weight] : values) total += weight;
  double sum = 0;
  for (const auto& [value, weight] : values) {
    sum += weight;
    if (sum >= 0.5 * total) return value;
  }
  return 0;
}

/// Standard deviation of a normal distribution over the median of its magnitudes.
constexpr double kSigmaPerMad = 1.4826;
/// Median length of a vector of two normal variables of standard deviation 1, and of its square.
constexpr double kMedianLengthInPlane = 1.17741;
constexpr double kMedianSquareInPlane = 2 * std::numbers::ln2;

/// Standard deviation about zero of what is normal in a set, from the median magnitude: a third may be anything.
inline double RobustSigma(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return kSigmaPerMad * Median(std::move(values));
}

}  // namespace turnscale
