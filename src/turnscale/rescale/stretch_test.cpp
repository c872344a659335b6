// SPDX-License-Identifier: MIT
#include "turnscale/rescale/stretch.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/rescale/drifting_drive.h"

namespace turnscale {
namespace {

const LeverArm kCar{1.0, 0};
const Eigen::Quaterniond kTilted = RotationFromYawPitchRoll({0.1, -0.2, 0.05});

TEST(SwaySteps, ReadTheConstrainedMotionBack) {
  const ScaledDrive drive = MakeScaledDrive({{20, 0.8, 0.05}}, kCar, kTilted, 4.0);
  const std::vector<SwayStep> steps = SwaySteps(drive.trajectory, kTilted, 2, true, {});
  ASSERT_EQ(steps.size(), 10u);
  for (const SwayStep& step : steps) {
    EXPECT_NEAR(step.psi, 0.1, 1e-9);
    EXPECT_NEAR(step.sway, kCar.length * 2 * std::sin(0.05) / 4.0, 1e-9);
    EXPECT_NEAR(step.speed, step.length / 0.2, 1e-9);
    EXPECT_NEAR(step.roll, 0, 1e-9);
  }
}

TEST(SwaySteps, PitchOfTheCameraIsNoRoll) {
  const Eigen::Quaterniond looks_down = RotationFromYawPitchRoll({0, -0.15, 0});
  const ScaledDrive drive = MakeScaledDrive({{20, 0.8, 0.05}}, kCar, looks_down, 4.0);
  for (const SwayStep& step : SwaySteps(drive.trajectory, Eigen::Quaterniond::Identity(), 2, true, {})) {
    EXPECT_NEAR(step.psi, 0.1, 1e-9);
    EXPECT_NEAR(step.sway, kCar.length * 2 * std::sin(0.05) / 4.0, 1e-9);
    EXPECT_NEAR(step.roll, 0, 1e-9);
  }
}

TEST(SwaySteps, NoneReachesAcrossAGap) {
  const ScaledDrive drive = MakeScaledDrive({{40, 0.8, 0.05}}, kCar, kTilted, 4.0);
  const std::vector<SwayStep> steps = SwaySteps(drive.trajectory, kTilted, 3, true, {}, {20});
  int pose = 0;
  for (const SwayStep& step : steps) {
    EXPECT_EQ(step.first, pose);
    pose = step.last;
    EXPECT_EQ(step.after_gap, step.last == 20);
    EXPECT_TRUE(!step.after_gap || (step.first == 19 && step.length == 0 && !step.usable));
  }
  int after_gap = 0;
  for (const Stretch& stretch : SplitIntoStretches(steps, {})) {
    after_gap += stretch.after_gap;
    EXPECT_EQ(stretch.after_gap, steps[stretch.first].after_gap);
    EXPECT_TRUE(std::none_of(steps.begin() + stretch.first + 1, steps.begin() + stretch.last + 1,
                             [](const SwayStep& step) { return step.after_gap; }))
        << "a gap is where a stretch begins";
  }
  EXPECT_EQ(after_gap, 1);
}

TEST(SwaySteps, RollIsToTheRight) {
  Trajectory leaning{{0, {}}, {1, {RotationFromYawPitchRoll({0, 0, 0.02}), {0, 0, 1}}}};
  EXPECT_NEAR(SwaySteps(leaning, Eigen::Quaterniond::Identity(), 1, true, {}).front().roll, 0.02, 1e-12);
}

TEST(KeySpacing, FollowsTheFrameRateNotTheStraights) {
  const auto spacing = [](double psi) {
    const ScaledDrive drive =
        MakeScaledDrive({{300, 0.9, 0}, {20, 0.9, psi}, {300, 0.9, 0}}, kCar, Eigen::Quaterniond::Identity(), 1.0);
    return KeySpacing(drive.trajectory, Eigen::Quaterniond::Identity(), {});
  };
  EXPECT_EQ(spacing(6 / kDegreesPerRadian), 1);
  EXPECT_EQ(spacing(1.5 / kDegreesPerRadian), 2);
  EXPECT_EQ(spacing(0.5 / kDegreesPerRadian), 6);
  EXPECT_EQ(spacing(0), 20);
}

TEST(Stretches, CoverEveryStepOnce) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(7), kCar, Eigen::Quaterniond::Identity(), 1.0);
  const std::vector<SwayStep> steps = SwaySteps(drive.trajectory, Eigen::Quaterniond::Identity(), 1, true, {});
  const std::vector<Stretch> stretches = SplitIntoStretches(steps, {});
  int next = 0;
  int turns = 0;
  double length = 0;
  for (const Stretch& stretch : stretches) {
    EXPECT_EQ(stretch.first, next);
    EXPECT_GE(stretch.last, stretch.first);
    EXPECT_NEAR(stretch.middle, length + stretch.length / 2, 1e-9);
    EXPECT_TRUE(stretch.turning || stretch.last - stretch.first < 2 * StretchOptions().max_straight_steps);
    next = stretch.last + 1;
    length += stretch.length;
    turns += stretch.turning;
  }
  EXPECT_EQ(next, static_cast<int>(steps.size()));
  EXPECT_EQ(turns, 7);
}

}  // namespace
}  // namespace turnscale
