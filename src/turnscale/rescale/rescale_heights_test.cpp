// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/rescale/test_rescale_drive.h"

namespace turnscale {
namespace {

constexpr double kHeight = 1.4;  // metres

// Of a camera at kHeight, at every pose but those before `first`.
std::vector<PathHeight> HeightsOf(const ScaledDrive& drive, std::size_t first = 0) {
  Random random(5);
  std::vector<PathHeight> heights;
  for (std::size_t i = first; i < drive.trajectory.size(); ++i) {
    const double error = 1 + 0.01 * random.Gaussian();
    heights.push_back({drive.trajectory[i].time, kHeight / drive.metres_per_unit[i] * error, 0.01});
  }
  return heights;
}

// One corner, and two kilometres straight on.
std::vector<DriveSegment> LongStraight() {
  std::vector<DriveSegment> route = CityRoute(1);
  route.push_back({2000, 0.9, 0});
  return route;
}

double EndError(const RescaleResult& result, const ScaledDrive& drive) {
  return std::abs(std::log(result.poses.back().metres_per_unit / drive.metres_per_unit.back()));
}

TEST(RescaleHeights, HoldTheScaleAfterATurn) {
  const ScaledDrive drive = MakeScaledDrive(LongStraight(), kCar, kIdentity, kUnit, {.drift = 0.002}, 3);
  RescaleOptions options = OptionsFor(kCar);
  options.car.side_slip_sigma = 0;  // else it is most of the turn's sigma
  options.car.lever_arm_sigma = 0.005;
  const RescaleResult without = RescaleTrajectory(options, drive.trajectory);
  const RescaleResult with = RescaleTrajectory(options, drive.trajectory, {}, HeightsOf(drive));
  ASSERT_TRUE(without.observable && with.observable);
  EXPECT_GT(EndError(without, drive), 0.05) << "the drift of the drive";
  EXPECT_LT(EndError(with, drive), 0.03);
  EXPECT_LT(with.poses.back().sigma, 0.85 * without.poses.back().sigma);
  EXPECT_NEAR(with.estimate->car.camera_height, kHeight, 3 * with.estimate->car.camera_height_sigma);
  EXPECT_LT(with.estimate->car.camera_height_sigma, 0.08);
  EXPECT_EQ(without.estimate->car.camera_height, 0);
  EXPECT_NEAR(with.poses.back().filtered_metres_per_unit, drive.metres_per_unit.back(), 0.04 * kUnit) << "causal, too";
}

TEST(RescaleHeights, AKnownHeightNeedsNoTurnAndNoLeverArm) {
  const ScaledDrive drive = MakeScaledDrive({{900, 0.9, 0}}, kCar, kIdentity, kUnit, {.drift = 0.002}, 4);
  RescaleOptions options;
  options.car.camera_height = kHeight;
  options.car.camera_height_sigma = 0.014;
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory, {}, HeightsOf(drive));
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_LT(WorstLogError(result, drive), 0.04);
  EXPECT_GT(result.poses.back().sigma, 0.01) << "that of the height";
  EXPECT_LT(result.poses.back().sigma, 0.03);
  EXPECT_TRUE(std::ranges::all_of(result.estimate->from_road, [](char road) { return road != 0; }));

  const RescaleResult none = RescaleTrajectory(options, drive.trajectory);
  EXPECT_FALSE(none.observable);
  EXPECT_EQ(none.reason, "too few steps show the height above the road");

  options.car.camera_height_sigma = 0.3;
  const RescaleResult vague = RescaleTrajectory(options, drive.trajectory, {}, HeightsOf(drive));
  EXPECT_FALSE(vague.observable);
  EXPECT_EQ(vague.reason,
            "the drive leaves the scale uncertain by 21 %, more than 15 %; give the lever arm, or the height of the "
            "camera more exactly");
}

TEST(RescaleHeights, AWrongLengthIsReported) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit, {}, 5);
  RescaleOptions options = OptionsFor(kCar);
  options.car.camera_height = 1.25 * kHeight;
  options.car.camera_height_sigma = 0.01 * options.car.camera_height;
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory, {}, HeightsOf(drive));
  ASSERT_TRUE(result.observable) << result.reason;
  ASSERT_TRUE(result.estimate->height_conflict);
  EXPECT_NEAR(result.estimate->height_conflict->found, kHeight, 0.05);
}

TEST(RescaleHeights, TimesDecideWhichStepTheyBelongTo) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(2), kCar, kIdentity, kUnit, {}, 6);
  constexpr std::size_t kFirst = 50;
  std::vector<PathHeight> heights = HeightsOf(drive, kFirst);
  heights.push_back({drive.trajectory.back().time + 1, 100, 0.01});
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory, {}, heights);
  ASSERT_TRUE(result.observable) << result.reason;
  for (const VehicleStep& step : result.steps) {
    EXPECT_EQ(step.height > 0, step.usable && step.last >= static_cast<int>(kFirst)) << step.first;
    if (step.height > 0) {
      EXPECT_NEAR(step.height, kHeight / kUnit, 0.03 * kHeight / kUnit);
      EXPECT_NEAR(step.height_sigma, 0.01, 1e-12) << "steps' heights share their errors";
    }
  }
}

TEST(RescaleHeights, NeedTimesOfThePoses) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(2), kCar, kIdentity, kUnit);
  RescaleOptions options = OptionsFor(kCar);
  options.timed = false;
  EXPECT_TRUE(RescaleTrajectory(options, drive.trajectory).observable);
  try {
    RescaleTrajectory(options, drive.trajectory, {}, HeightsOf(drive));
    FAIL() << "times that are none decide where the heights belong";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find("heights: the poses have no times"), 0U) << error.what();
  }
}

TEST(RescaleHeights, RefusesWhatMakesNoSense) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(1), kCar, kIdentity, kUnit);
  for (const std::vector<PathHeight>& heights : std::vector<std::vector<PathHeight>>{
           {{1, 0, 0.01}}, {{1, -1, 0.01}}, {{1, 1, 0}}, {{2, 1, 0.01}, {2, 1, 0.01}}, {{NAN, 1, 0.01}}}) {
    EXPECT_THROW(RescaleTrajectory(OptionsFor(kCar), drive.trajectory, {}, heights), InputError);
  }
}

}  // namespace
}  // namespace turnscale
