// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

namespace turnscale {

/// Huber's weight of a deviation: 1 up to `threshold`, then falling with its inverse.
inline double HuberWeight(double deviation, double threshold) {
  return std::min(1.0, threshold / std::max(std::abs(deviation), 1e-9));
}

/// Threshold of Tukey's biweight, standard deviations: it is then 95 % efficient on Gaussian noise.
inline constexpr double kTukeyThreshold = 4.685;

/// Weight of Tukey's biweight: 1 at a deviation of 0, 0 from a magnitude of `threshold` on.
inline double TukeyWeight(double deviation, double threshold) {
  const double share = deviation / threshold;
  const double inside = 1 - share * share;
  return inside > 0 ? inside * inside : 0.0;
}

}  // namespace turnscale
