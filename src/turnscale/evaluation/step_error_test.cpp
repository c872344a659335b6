// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/step_error.h"

#include <gtest/gtest.h>

#include "turnscale/evaluation/test_drive.h"

namespace turnscale {
namespace {

TEST(Steps, AlongThePathHaveTheAskedLengthAndKnowTurns) {
  const Trajectory drive = WindingDrive(211, 0.4);
  const PosePairs pairs = AssociateByTime(drive, drive);
  const std::vector<Step> steps = StepsAlongPath(pairs);
  ASSERT_EQ(steps.size(), 70U) << "three poses of 0.4 m each";
  int turning = 0;
  for (const Step& step : steps) {
    EXPECT_EQ(step.last - step.first, 3);
    const Eigen::Quaterniond turn = pairs[step.first].truth.rotation.conjugate() * pairs[step.last].truth.rotation;
    EXPECT_EQ(step.turning, std::abs(TwistAboutY(turn)) > 2 / kDegreesPerRadian);
    turning += step.turning ? 1 : 0;
  }
  EXPECT_GT(turning, 10);
  EXPECT_LT(turning, 68);
}

TEST(Steps, BetweenKeyframesFollowTheTable) {
  const Trajectory drive = WindingDrive(20);
  Trajectory numbered = drive;
  for (size_t i = 0; i < drive.size(); ++i) numbered[i].time = static_cast<double>(i);
  const std::vector<KeyframeRow> keyframes = {{0, 0.0, false}, {4, 0.4, true}, {6, 0.60001, false}, {90, 9.0, true}};
  for (const KeyframeKey key : {KeyframeKey::kTime, KeyframeKey::kFrame}) {
    const Trajectory& poses = key == KeyframeKey::kTime ? drive : numbered;
    const std::vector<Step> steps = StepsBetweenKeyframes(AssociateByTime(poses, poses), keyframes, key);
    ASSERT_EQ(steps.size(), 2U);
    EXPECT_EQ(steps[0].first, 0);
    EXPECT_EQ(steps[0].last, 4);
    EXPECT_TRUE(steps[0].turning);
    EXPECT_EQ(steps[1].last, 6);
    EXPECT_FALSE(steps[1].turning);
  }
  const PosePairs pairs = AssociateByTime(drive, drive);
  EXPECT_TRUE(StepsBetweenKeyframes(pairs, {{90, 9.0, true}, {91, 9.1, true}}, KeyframeKey::kTime).empty());
}

TEST(StepErrors, ScaleErrorRatioIsTheScalesError) {
  const Trajectory truth = WindingDrive(300);
  const PosePairs pairs = AssociateByTime(Scaled(truth, 0.93), truth);
  const std::vector<Step> steps = StepsAlongPath(pairs);
  const StepErrors errors = MeasureSteps(pairs, steps, false);
  EXPECT_EQ(errors.scale.count, static_cast<int>(steps.size()));
  EXPECT_NEAR(errors.scale.rms, 0.07, 1e-9);
  EXPECT_NEAR(errors.scale.median, 0.07, 1e-9);
  EXPECT_NEAR(errors.psi.rms, 0, 1e-9);
  EXPECT_NEAR(MeasureSteps(pairs, steps, false, 1 / 0.93).scale.rms, 0, 1e-9);
}

TEST(StepErrors, TurningStepsAreCountedApart) {
  const Trajectory truth = WindingDrive(300);
  PosePairs pairs = AssociateByTime(truth, truth);
  const std::vector<Step> steps = StepsAlongPath(pairs);
  // Every turning step is estimated 20 % too long, every other one exactly.
  for (const Step& step : steps) {
    RigidTransform motion = pairs[step.first].truth.inverse() * pairs[step.last].truth;
    if (step.turning) motion.translation *= 1.2;
    pairs[step.last].estimate = pairs[step.first].estimate * motion;
  }
  const StepErrors turning = MeasureSteps(pairs, steps, true);
  const StepErrors all = MeasureSteps(pairs, steps, false);
  EXPECT_NEAR(turning.scale.rms, 0.2, 1e-9);
  EXPECT_NEAR(all.scale.rms, 0.2 * std::sqrt(1.0 * turning.scale.count / all.scale.count), 1e-9);
  EXPECT_NEAR(all.scale.max, 0.2, 1e-9);
}

TEST(StepErrors, PsiIsTheVehiclesTurningAngle) {
  const Trajectory truth = WindingDrive(100, 1.01);
  const Eigen::Quaterniond vehicle_from_camera = RotationFromYawPitchRoll({0.2, -0.1, 0.05});
  const auto mounted = [&](double extra_psi) {
    Trajectory drive = truth;
    for (size_t i = 0; i < drive.size(); ++i) {
      RigidTransform& pose = drive[i].world_from_camera;
      pose.rotation =
          pose.rotation * RotationFromVector({0, extra_psi * static_cast<double>(i), 0}) * vehicle_from_camera;
    }
    return drive;
  };
  const PosePairs pairs = AssociateByTime(mounted(0.001), mounted(0));
  const std::vector<Step> steps = StepsAlongPath(pairs);
  StepErrorOptions options;
  options.vehicle_from_camera = vehicle_from_camera;
  EXPECT_NEAR(MeasureSteps(pairs, steps, false, 1, options).psi.rms, 0.001, 2e-6);
}

TEST(StepErrors, StandstillDoesNotExplode) {
  Trajectory truth = WindingDrive(50);
  Trajectory estimate = truth;
  for (int i = 0; i < 20; ++i) {
    truth.push_back(truth.back());
    truth.back().time += 0.1;
    truth.back().world_from_camera.translation.x() += 1e-4;
    estimate.push_back(estimate.back());
    estimate.back().time += 0.1;
    estimate.back().world_from_camera.translation.x() += 0.05;
  }
  const PosePairs pairs = AssociateByTime(estimate, truth);
  std::vector<Step> every_pose;
  for (int i = 1; i < static_cast<int>(pairs.size()); ++i) every_pose.push_back({i - 1, i, true});
  const StepErrors errors = MeasureSteps(pairs, every_pose, false);
  EXPECT_EQ(errors.scale.count, 49);
  EXPECT_NEAR(errors.scale.max, 0, 1e-9);
}

TEST(StepErrors, NoTurningStepGivesNoNumber) {
  const Trajectory drive = WindingDrive(10);
  const PosePairs pairs = AssociateByTime(drive, drive);
  const StepErrors errors = MeasureSteps(pairs, {{0, 9, false}}, true);
  EXPECT_EQ(errors.scale.count, 0);
  EXPECT_TRUE(std::isnan(errors.scale.rms));
}

}  // namespace
}  // namespace turnscale
