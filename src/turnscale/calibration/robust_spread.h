// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace turnscale {

/// The value below which this share of the values lies; 0 of none.
inline double QuantileOf(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(std::floor(share * static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// Standard deviation about zero of what is normal in a set: the median magnitude, times 1.4826.
inline double RobustSpread(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return 1.4826 * QuantileOf(std::move(values), 0.5);
}

}  // namespace turnscale
