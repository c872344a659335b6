// SPDX-License-Identifier: MIT
#include "turnscale/mapping/cell_weights.h"

#include <algorithm>
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

TEST(CellWeights, ShareOfCellsDoesNotDependOnHowManyPixelsThereAre) {
  const Pinhole pinhole{100, 100, 300, 200};
  std::vector<Eigen::Vector2d> pixels;
  std::vector<char> is_in_middle;
  for (int column = 0; column < 600; column += 15) {
    const bool is_in_crowd = column >= 225 && column <= 375;
    for (int i = 0; i < (is_in_crowd ? 50 : 1); ++i) {
      pixels.emplace_back(column, 100);
      is_in_middle.push_back(is_in_crowd ? 1 : 0);
    }
  }
  EXPECT_NEAR(ShareOfCells(pinhole, pixels, is_in_middle, is_in_middle), 11.0 / 40, 0.05);
  // One of a crowd counts for nothing.
  std::vector<char> is_beside = is_in_middle;
  for (char& each : is_beside) each = each == 0 ? 1 : 0;
  *std::ranges::find(is_beside, 0) = 1;
  EXPECT_NEAR(ShareOfCells(pinhole, pixels, is_beside, is_beside), 29.0 / 40, 0.05);
  // So does a dashboard below.
  for (int column = 0; column < 600; column += 15) {
    pixels.emplace_back(column, 300);
    is_beside.push_back(0);
  }
  EXPECT_NEAR(ShareOfCells(pinhole, pixels, is_beside, is_beside), 29.0 / 40, 0.05);
  const std::vector<char> none(pixels.size(), 0);
  EXPECT_EQ(ShareOfCells(pinhole, pixels, none, none), 0);
  EXPECT_EQ(ShareOfCells(pinhole, pixels, none, is_beside), 0);
  EXPECT_EQ(ShareOfCells(pinhole, {}, {}, {}), 0);
}

}  // namespace
}  // namespace turnscale
