// SPDX-License-Identifier: MIT
#include "turnscale/scale/camera_height.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(HeightSigma, HasTheContradictionsOfTheScale) {
  ScaleEstimate estimate;
  estimate.car.camera_height = 1.5;
  estimate.car.camera_height_sigma = 0.03;
  EXPECT_EQ(HeightSigma(estimate), 0.03);
  EXPECT_NEAR(HeightSigma(estimate, 0.1), std::hypot(0.03, 0.15), 1e-12);
  estimate.height_conflict = HeightConflict{.given = 1.5, .found = 1.8};
  EXPECT_NEAR(HeightSigma(estimate), std::hypot(0.03, 0.75 * std::log(1.2)), 1e-12);
  estimate.height_conflict->contradicts_turns = true;
  EXPECT_NEAR(HeightSigma(estimate), std::hypot(0.03, 1.5 * std::sqrt(0.5) * std::log(1.2)), 1e-12);
}

TEST(FindUnusualHeight, TellsHowFarTheScaleIsProbablyOff) {
  for (const double usual : {0.0, 0.86, 1.3, 2.3}) EXPECT_FALSE(FindUnusualHeight(usual, 0.02)) << usual;
  for (const double unusual : {0.75, 2.5}) {
    EXPECT_TRUE(FindUnusualHeight(unusual, 0.1)) << unusual;
    EXPECT_FALSE(FindUnusualHeight(unusual, 0.5)) << unusual;
  }
  const std::optional<UnusualHeight> low = FindUnusualHeight(0.28, 0.1);
  ASSERT_TRUE(low);
  EXPECT_TRUE(low->is_low);
  EXPECT_NEAR(low->scale_error, std::log(5), 1e-12);
  const std::optional<UnusualHeight> high = FindUnusualHeight(2.8, 0.1);
  ASSERT_TRUE(high);
  EXPECT_FALSE(high->is_low);
  EXPECT_NEAR(high->scale_error, std::log(2), 1e-12);
}

}  // namespace
}  // namespace turnscale
