// SPDX-License-Identifier: MIT
#include "turnscale/calibration/lever_arm_fit.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/calibration/step_gatherer.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kTilted = RotationFromYawPitchRoll({5 * kDeg, 15 * kDeg, -10 * kDeg});

// Turns at two speeds.
std::vector<DriveSegment> TwoSpeeds() {
  std::vector<DriveSegment> route = TestRoute({1, -1});
  for (DriveSegment segment : TestRoute({-1, 1, 1})) {
    segment.camera_distance = 0.4;
    route.push_back(segment);
  }
  return route;
}

TEST(LeverArmFit, ReadsTheLeverArmOfARigidCar) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, -1}), {1.45, 0}, kTilted, 0.1 * kDeg)), kTilted};
  const LeverArmFit fit = FitLeverArm({drive});
  EXPECT_NEAR(fit.lever_arm.length, 1.45, 4 * fit.sigma_length);
  EXPECT_LT(fit.sigma_length, 0.05);
  EXPECT_EQ(fit.lever_arm.side_slip, 0);
}

TEST(LeverArmFit, TellsSlipFromLengthAtTwoSpeeds) {
  const MetricDrive drive{StepsAlong(TestPath(TwoSpeeds(), {1.45, 0.005}, kTilted)), kTilted};
  LeverArmFitOptions options;
  options.side_slip = true;
  const LeverArmFit fit = FitLeverArm({drive}, options);
  EXPECT_NEAR(fit.lever_arm.length, 1.45, 0.03);
  EXPECT_NEAR(fit.lever_arm.side_slip, 0.005, 0.0006);
}

TEST(LeverArmFit, AnErrorOfTheYawIsNoLeverArm) {
  const Eigen::Quaterniond off = RotationFromYawPitchRoll({1 * kDeg, 0, 0}) * kTilted;
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, 1}), {1.45, 0}, kTilted)), off};
  const LeverArmFit fit = FitLeverArm({drive});
  EXPECT_NEAR(fit.lever_arm.length, 1.45, 0.01);
  ASSERT_EQ(fit.yaw_correction.size(), 1U);
  EXPECT_NEAR(fit.yaw_correction[0], 1 * kDeg, 0.02 * kDeg);
}

TEST(LeverArmFit, NeedsATurn) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({}), {1.45, 0}, kTilted)), kTilted};
  EXPECT_THROW(FitLeverArm({drive}), InputError);
}

}  // namespace
}  // namespace turnscale
