// SPDX-License-Identifier: MIT
#include "turnscale/io/turn_warning.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

std::string Warning(const ScaleEstimate& estimate) {
  return TurnWarning(
      estimate, [](int turn) { return "turn " + std::to_string(turn); }, "the lever arm");
}

ScaleEstimate Fallback() {
  ScaleEstimate estimate;
  estimate.fell_back = true;
  estimate.converged = true;
  return estimate;
}

TEST(TurnWarning, IsEmptyUnlessTheTurnsAreTheReason) {
  EXPECT_EQ(Warning(Fallback()), "") << "single-turn scales by choice";
  ScaleEstimate smoothed;
  smoothed.converged = true;
  EXPECT_EQ(Warning(smoothed), "");
}

TEST(TurnWarning, NamesTheTurnThatDeviatesMost) {
  ScaleEstimate estimate = Fallback();
  estimate.test.contradicted = true;
  estimate.test.disagreement = 0.12;
  estimate.test.worst_turn = 3;
  EXPECT_EQ(Warning(estimate),
            "the turns are inconsistent by 12 % of scale, most of all the one at turn 3: the trajectory uses "
            "single-turn scales; check the lever arm");
}

TEST(TurnWarning, TellsThatTheEstimateDidNotConverge) {
  ScaleEstimate estimate = Fallback();
  estimate.converged = false;
  EXPECT_EQ(Warning(estimate),
            "the scale estimate did not converge: the trajectory uses single-turn scales; check the lever arm");
}

}  // namespace
}  // namespace turnscale
