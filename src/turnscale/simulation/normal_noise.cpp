// SPDX-License-Identifier: MIT
#include "turnscale/simulation/normal_noise.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

constexpr int kQuantiles = 1 << 16;

// The quantile in the middle of each of 2^16 equally likely parts: a 16-bit number becomes a normal one by a look-up.
std::vector<float> MakeQuantiles() {
  std::vector<float> quantiles(kQuantiles);
  double x = 0;
  for (int i = kQuantiles / 2; i < kQuantiles; ++i) {
    const double tail = 1 - (i + 0.5) / kQuantiles;
    // Newton from the neighbour's quantile; the tail is convex there, so that it is approached from below.
    for (int step = 0; step < 6; ++step) {
      const double excess = 0.5 * std::erfc(x / std::numbers::sqrt2) - tail;
      x += excess * std::sqrt(2 * std::numbers::pi) * std::exp(0.5 * x * x);
    }
    quantiles[static_cast<size_t>(i)] = static_cast<float>(x);
    quantiles[static_cast<size_t>(kQuantiles - 1 - i)] = static_cast<float>(-x);
  }
  return quantiles;
}

}  // namespace

void FillNormalNoise(std::uint64_t key, std::span<float> values) {
  static const std::vector<float> quantiles = MakeQuantiles();
  const std::uint64_t start = Hash(key);
  std::uint64_t bits = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    // Four numbers to a hash.
    bits = i % 4 == 0 ? Hash(start + i) : bits >> 16U;
    values[i] = quantiles[bits & 0xFFFFU];
  }
}

}  // namespace turnscale
