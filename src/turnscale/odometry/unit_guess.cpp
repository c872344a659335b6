// SPDX-License-Identifier: MIT
#include "turnscale/odometry/unit_guess.h"

#include <algorithm>
#include <cmath>

namespace turnscale {

UnitGuess Combine(const UnitGuess& a, const UnitGuess& b) {
  if (!(a.sigma < 1)) return b;
  if (!(b.sigma < 1)) return a;
  const double weight_a = 1 / (a.sigma * a.sigma);
  const double weight_b = 1 / (b.sigma * b.sigma);
  const double sum = weight_a + weight_b;
  const double mean = (weight_a * std::log(a.unit) + weight_b * std::log(b.unit)) / sum;
  const double contradiction = std::abs(std::log(a.unit / b.unit)) / std::hypot(a.sigma, b.sigma);
  return {std::exp(mean), std::max(1.0, contradiction) / std::sqrt(sum)};
}

}  // namespace turnscale
