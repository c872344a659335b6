// SPDX-License-Identifier: MIT
#include "turnscale/odometry/scale_uncertainty.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// Keyframes 2 m apart.
Map Street(int keyframes) {
  Map map;
  for (int k = 0; k < keyframes; ++k)
    map.keyframes.push_back({k, 0.1 * k, {Eigen::Quaterniond::Identity(), {0, 0, -2.0 * k}}, {}, false});
  return map;
}

ScaleOptions Drift(double per_root_metre) {
  ScaleOptions options;
  options.drift_per_root_metre = per_root_metre;
  return options;
}

TEST(ScaleUncertainty, GrowsWithTheRootOfTheDistance) {
  EXPECT_DOUBLE_EQ(CarriedVariance(Drift(0.001), 0.02, {}), 0.02 * 0.02);
  EXPECT_NEAR(std::sqrt(CarriedVariance(Drift(0.001), 0, {100, 0})), 0.01, 1e-15);
  EXPECT_NEAR(CarriedVariance(Drift(0.002), 0.01, {50, 0}), 1e-4 + 2e-4, 1e-15);
}

TEST(ScaleUncertainty, InfiniteWhereNothingWasObserved) {
  const std::vector<double> sigmas = ScaleSigmas({}, Street(4), {});
  ASSERT_EQ(sigmas.size(), 4U);
  for (const double sigma : sigmas) EXPECT_TRUE(std::isinf(sigma));
  EXPECT_TRUE(ScaleSigmas({}, Map{}, {}).empty());
}

TEST(ScaleUncertainty, IsCarriedBothWaysFromOneTurn) {
  const std::vector<double> sigmas = ScaleSigmas(Drift(0.01), Street(9), {{3, 5, 0.02}});
  for (const int k : {3, 4, 5}) EXPECT_EQ(sigmas[k], 0.02);
  for (const int steps : {1, 2, 3}) {
    const double expected = std::sqrt(0.02 * 0.02 + 1e-4 * 2 * steps);
    EXPECT_NEAR(sigmas[5 + steps], expected, 1e-12);
    EXPECT_NEAR(sigmas[3 - steps], expected, 1e-12);
  }
}

TEST(ScaleUncertainty, BetweenTwoTurnsBothTell) {
  const std::vector<double> sigmas = ScaleSigmas(Drift(0.01), Street(12), {{0, 2, 0.02}, {8, 10, 0.04}});
  for (int k = 3; k < 8; ++k) {
    const double before = 0.02 * 0.02 + 1e-4 * 2 * (k - 2);
    const double after = 0.04 * 0.04 + 1e-4 * 2 * (8 - k);
    EXPECT_NEAR(sigmas[k], 1 / std::sqrt(1 / before + 1 / after), 1e-12) << k;
  }
  EXPECT_NEAR(sigmas[11], std::sqrt(0.04 * 0.04 + 2e-4), 1e-12) << "only the nearest turn before tells";
}

}  // namespace
}  // namespace turnscale
