// SPDX-License-Identifier: MIT
#include "turnscale/mapping/cell_weights.h"

#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(CellWeights, ACrowdSharesAWeight) {
  const Pinhole pinhole{400, 400, 300, 200};
  std::vector<Eigen::Vector2d> pixels(10, Eigen::Vector2d(100, 100));
  pixels.emplace_back(200, 100);
  pixels.emplace_back(203, 97);
  const std::vector<double> weights = CellWeights(pinhole, pixels, 2);
  ASSERT_EQ(weights.size(), pixels.size());
  EXPECT_NEAR(std::accumulate(weights.begin(), weights.begin() + 10, 0.0), 2, 1e-12);
  EXPECT_EQ(weights[10], 1);
  EXPECT_EQ(weights[11], 1);
  EXPECT_TRUE(CellWeights(pinhole, {}, 2).empty());
}

}  // namespace
}  // namespace turnscale
