// SPDX-License-Identifier: MIT
#include "turnscale/scale/prior_fit.h"

#include <vector>

#include <gtest/gtest.h>

#include "turnscale/scale/drive_evidence.h"
#include "turnscale/scale/synthetic_steps.h"
#include "turnscale/scale/test_estimates.h"

namespace turnscale {
namespace {

PriorFit FitOf(const SyntheticSteps& drive, const CarPrior& car, const ScaleEstimatorOptions& options = {}) {
  return FitPriors(EvidenceOfDrive(drive.steps, options.segments, options.evidence), car, options);
}

SyntheticSteps TownDrive(double direction, double lag) {
  DriveErrors errors = kNoise;
  errors.lag = lag;
  return MakeSteps(TownRoad(8, 2), kCar, direction, kUnit, errors, 3);
}

TEST(PriorFit, APriorThatHoldsStays) {
  const PriorFit fit = FitOf(TownDrive(0, 0), PriorOf(kCar));
  ASSERT_TRUE(fit.drive);
  EXPECT_FALSE(fit.freed.yaw);
  EXPECT_FALSE(fit.freed.lag);
  EXPECT_EQ(fit.car.yaw_sigma, PriorOf(kCar).yaw_sigma);
  EXPECT_EQ(fit.car.image_lag_sigma, 0);
}

TEST(PriorFit, FreesWhatTheDriveContradicts) {
  const ScaleEstimatorOptions options;
  for (const bool turned : {false, true})
    for (const bool lags : {false, true}) {
      SCOPED_TRACE(testing::Message() << turned << ' ' << lags);
      const PriorFit fit = FitOf(TownDrive(turned ? 3 * kDegree : 0, lags ? 0.15 : 0), PriorOf(kCar));
      ASSERT_TRUE(fit.drive);
      EXPECT_EQ(fit.freed.yaw, turned);
      EXPECT_EQ(fit.freed.lag, lags);
      EXPECT_EQ(fit.given.yaw_sigma, PriorOf(kCar).yaw_sigma);
      EXPECT_EQ(fit.car.yaw_sigma, turned ? options.contradicted_yaw_sigma : fit.given.yaw_sigma);
      EXPECT_EQ(fit.car.image_lag_sigma, lags ? options.stabilisation.lag_sigma : 0.0);
      EXPECT_NEAR(fit.drive->car.mean[kLag], lags ? 0.15 : 0.0, 0.02);
    }
}

// A yaw so wrong that no turn seems usable.
TEST(PriorFit, AYawThatHidesTheTurnsIsFreed) {
  const std::vector<StretchOfRoad> corner = {
      {2, 1.6 * kDegree, 1.2, 4}, {33, 2.5 * kDegree, 0.26, 4}, {2, 1.6 * kDegree, 1.2, 4}};
  const PriorFit fit = FitOf(MakeSteps(corner, kCar, 20 * kDegree, kUnit, kNoise, 1), PriorOf(kCar));
  EXPECT_TRUE(fit.freed.yaw);
}

TEST(PriorFit, NeedsATurnOrAHeight) {
  const std::vector<StretchOfRoad> straight = {{40, 0, 6, 10}};
  SyntheticSteps drive = MakeSteps(straight, kCar, 0, kUnit, kNoise, 1);
  CarPrior car = PriorOf(kCar);
  EXPECT_FALSE(FitOf(drive, car).drive);
  car.camera_height = 1.4;
  car.camera_height_sigma = 0.01;
  ShowRoad(car.camera_height, {.step = 0.01, .road = 0.005}, 1, drive);
  EXPECT_TRUE(FitOf(drive, car).drive);
  EXPECT_FALSE(FitOf(drive, WithoutHeight(car)).drive);
}

TEST(PriorFit, AKnownLagLeavesNoErrorByOne) {
  const ScaleEstimatorOptions options;
  const SyntheticSteps drive = TownDrive(0, 0);
  const DriveEvidence evidence = EvidenceOfDrive(drive.steps, options.segments, options.evidence);
  CarPrior car = PriorOf(kCar);
  EXPECT_GT(ErrorByLag(evidence, FitPriors(evidence, car, options), options), 0);
  car.image_lag_sigma = 0.01;
  EXPECT_EQ(ErrorByLag(evidence, FitPriors(evidence, car, options), options), 0);
}

}  // namespace
}  // namespace turnscale
