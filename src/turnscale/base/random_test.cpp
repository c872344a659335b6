// SPDX-License-Identifier: MIT
#include "turnscale/base/random.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(Hash, IsSplitmix64) {
  // The first numbers of the published generator from 0 and from 1234567.
  EXPECT_EQ(Hash(0), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(Hash(1234567), 6457827717110365317ULL);
}

TEST(Hash, UniformsFillTheirRangeWhateverTheirPlace) {
  double mean = 0;
  constexpr int kSide = 100;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const float value = HashUniform(7, row, column);
      ASSERT_GE(value, 0);
      ASSERT_LT(value, 1);
      mean += value / (kSide * kSide);
    }
  }
  EXPECT_NEAR(mean, 0.5, 0.01);
  EXPECT_NE(HashUniform(1, 2), HashUniform(2, 1));
  EXPECT_EQ(ToUniform(0), 0);
  EXPECT_LT(ToUniform(~0ULL), 1);
}

// Simulated drives depend on these numbers.
TEST(Random, StaysTheSame) {
  Random random(1);
  EXPECT_EQ(random.Uniform(), 0.36818951565166946);
  EXPECT_EQ(random.Below(1000), 693);
  EXPECT_EQ(random.Uniform(-1, 1), 0.76957963306982635);
}

TEST(Random, HasTheMomentsItSays) {
  Random random(3);
  constexpr int kCount = 20000;
  double mean = 0;
  double square = 0;
  int chances = 0;
  for (int i = 0; i < kCount; ++i) {
    const double value = random.Gaussian();
    mean += value / kCount;
    square += value * value / kCount;
    chances += random.Chance(0.3) ? 1 : 0;
    const float between = random.UniformFloat(-2, 3);
    ASSERT_GE(between, -2);
    ASSERT_LE(between, 3);
  }
  EXPECT_NEAR(mean, 0, 0.03);
  EXPECT_NEAR(square, 1, 0.05);
  EXPECT_NEAR(chances, 0.3 * kCount, 0.02 * kCount);
}

}  // namespace
}  // namespace turnscale
