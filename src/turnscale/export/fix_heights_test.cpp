// SPDX-License-Identifier: MIT
#include "turnscale/export/fix_heights.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// On a plane that rises by these shares to the right and ahead; `length` metres, to one side and back.
std::vector<HeightOfFix> OnASlope(double right, double ahead, double length, int fixes) {
  Random random(3);
  std::vector<HeightOfFix> heights;
  for (int i = 0; i < fixes; ++i) {
    const double y = length * i / (fixes - 1);
    const Eigen::Vector3d path(0.2 * length * std::sin(2 * M_PI * i / fixes), y, 0);
    heights.push_back({path, 110 + right * path.x() + ahead * y + 8 * random.Gaussian(), 10});
    if (i % 10 == 4) heights.back().height += 150;
  }
  return heights;
}

double RiseAhead(const HeightPlacement& placed) {
  const Eigen::Vector3d ahead = placed.tilt * Eigen::Vector3d::UnitY();
  return ahead.z() / ahead.head<2>().norm();
}

TEST(FixHeights, GiveTheMeanSlopeInNoiseAndOutliers) {
  for (const double ahead : {0.06, 0.0, -0.1}) {
    const HeightPlacement placed = PlaceHeights(OnASlope(-0.02, ahead, 3000, 120));
    EXPECT_NEAR(RiseAhead(placed), ahead, 0.003);
    const Eigen::Vector3d right = placed.tilt * Eigen::Vector3d::UnitX();
    EXPECT_NEAR(right.z() / right.head<2>().norm(), -0.02, 0.01);
    EXPECT_NEAR(placed.height, 110, 5);
  }
}

TEST(FixHeights, AFewCloseToEachOtherHardlyTiltThePath) {
  const HeightPlacement placed = PlaceHeights(OnASlope(0, 0, 60, 8));
  EXPECT_LT(std::abs(RiseAhead(placed)), 0.02);
  const HeightPlacement one = PlaceHeights({{{10, 20, 3}, 50, 10}});
  EXPECT_NEAR(one.height, 47, 1e-9);
  EXPECT_NEAR(RiseAhead(one), 0, 1e-12);
}

TEST(FixHeights, HillsOfThePathItselfStay) {
  std::vector<HeightOfFix> heights;
  for (int i = 0; i <= 40; ++i) {
    const double y = 50.0 * i;
    heights.push_back({{0, y, 20 * std::sin(0.01 * y)}, 300 + 0.04 * y + 20 * std::sin(0.01 * y), 1});
  }
  const HeightPlacement placed = PlaceHeights(heights);
  EXPECT_NEAR(RiseAhead(placed), 0.04, 1e-4);
  EXPECT_NEAR(placed.height, 300, 0.1);
}

}  // namespace
}  // namespace turnscale
