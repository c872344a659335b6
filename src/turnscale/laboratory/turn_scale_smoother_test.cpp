// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/turn_scale_smoother.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

std::vector<Eigen::Vector3d> Straight(int keyframes) {
  std::vector<Eigen::Vector3d> centres;
  for (int k = 0; k < keyframes; ++k) centres.emplace_back(0, 0, k);
  return centres;
}

std::vector<ObservedTurn> Turns() {
  return {{{10, 20, 1.5}, 1.0, 0.02}, {{110, 120, 1.5}, 1.1, 0.02}, {{210, 220, 1.5}, 0.9, 0.01}};
}

TEST(TurnScaleSmoother, WithoutDriftAllTurnsShareTheirWeightedMean) {
  std::vector<ObservedTurn> turns = Turns();
  SmoothTurnScales(Straight(300), 0, turns);
  const double mean = (std::log(1.0) + std::log(1.1) + 4 * std::log(0.9)) / 6;
  for (const ObservedTurn& turn : turns) {
    EXPECT_NEAR(std::log(turn.metres_per_unit), mean, 1e-12);
    EXPECT_NEAR(turn.relative_sigma, 0.02 / std::sqrt(6.0), 1e-12);
  }
}

TEST(TurnScaleSmoother, WithMuchDriftEachTurnKeepsItsOwn) {
  std::vector<ObservedTurn> turns = Turns();
  SmoothTurnScales(Straight(300), 100, turns);
  EXPECT_NEAR(turns[0].metres_per_unit, 1.0, 1e-4);
  EXPECT_NEAR(turns[1].metres_per_unit, 1.1, 1e-4);
  EXPECT_NEAR(turns[2].metres_per_unit, 0.9, 1e-4);
  EXPECT_NEAR(turns[1].relative_sigma, 0.02, 1e-6);
}

}  // namespace
}  // namespace turnscale
