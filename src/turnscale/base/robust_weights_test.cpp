// SPDX-License-Identifier: MIT
#include "turnscale/base/robust_weights.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(RobustWeights, HuberFallsWithTheInverse) {
  EXPECT_EQ(HuberWeight(0, 1.5), 1);
  EXPECT_EQ(HuberWeight(-1.5, 1.5), 1);
  EXPECT_EQ(HuberWeight(3, 1.5), 0.5);
  EXPECT_EQ(HuberWeight(-6, 1.5), 0.25);
}

TEST(RobustWeights, TukeyReachesZero) {
  EXPECT_EQ(TukeyWeight(0, 4), 1);
  EXPECT_EQ(TukeyWeight(-2, 4), 0.5625);
  EXPECT_EQ(TukeyWeight(4, 4), 0);
  EXPECT_EQ(TukeyWeight(-9, 4), 0);
}

}  // namespace
}  // namespace turnscale
