// SPDX-License-Identifier: MIT
#include "turnscale/base/quantiles.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(Quantiles, AreValuesOfTheSet) {
  EXPECT_EQ(Quantile({}, 0.5), 0);
  EXPECT_EQ(Quantile({7}, 0), 7);
  EXPECT_EQ(Quantile({7}, 1), 7);
  EXPECT_EQ(Quantile({5, 1, 4, 2, 3}, 0.2), 2);
  EXPECT_EQ(Quantile({5, 1, 4, 2, 3}, 1), 5);
  EXPECT_EQ(Median({5, 1, 4, 2, 3}), 3);
  EXPECT_EQ(Median({4, 1, 3, 2}), 3);
}

TEST(Quantiles, WeighTheirValues) {
  EXPECT_EQ(WeightedMedian({}), 0);
  EXPECT_EQ(WeightedMedian({{3, 1}, {1, 1}, {2, 1}}), 2);
  EXPECT_EQ(WeightedMedian({{3, 1}, {1, 5}, {2, 1}}), 1);
  EXPECT_EQ(WeightedMedian({{3, 1}, {1, 1}, {2, 2}}), 2);
}

TEST(Quantiles, RobustSigmaBearsOutliers) {
  EXPECT_EQ(RobustSigma({}), 0);
  EXPECT_DOUBLE_EQ(RobustSigma({-1, 100, 2, -3, 0.5}), 2 * kSigmaPerMad);
}

}  // namespace
}  // namespace turnscale
