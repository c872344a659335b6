// SPDX-License-Identifier: MIT
#include "turnscale/odometry/unit_guess.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(UnitGuess, GuessesThatAgreeAreBetterTogether) {
  const UnitGuess both = Combine({2, 0.3}, {2, 0.4});
  EXPECT_NEAR(both.unit, 2, 1e-12);
  EXPECT_NEAR(both.sigma, 0.24, 1e-12);
}

TEST(UnitGuess, TheMeanIsNearerToTheBetterGuess) {
  const UnitGuess both = Combine({1, 0.1}, {1.2, 0.2});
  EXPECT_NEAR(std::log(both.unit), std::log(1.2) / 5, 1e-12);
  EXPECT_NEAR(both.sigma, 0.1 * 0.2 / std::hypot(0.1, 0.2), 1e-12);
}

TEST(UnitGuess, AContradictionWidensSigma) {
  const UnitGuess both = Combine({1, 0.3}, {3, 0.3});
  EXPECT_NEAR(both.unit, std::sqrt(3), 1e-12);
  EXPECT_NEAR(both.sigma, std::log(3) / 2, 1e-12) << "either guess is one sigma away";
}

TEST(UnitGuess, AGuessOfNothingIsLeftOut) {
  const UnitGuess known{1.5, 0.2};
  for (const UnitGuess& both : {Combine(known, {}), Combine({}, known)}) {
    EXPECT_EQ(both.unit, known.unit);
    EXPECT_EQ(both.sigma, known.sigma);
  }
  EXPECT_EQ(Combine({}, {}).sigma, 1);
}

}  // namespace
}  // namespace turnscale
