// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_trials.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/laboratory/scale_drive.h"

namespace turnscale {
namespace {

// A short drive with all nine turns, so that a run takes a moment.
ScaleTrials SmallTrials() {
  ScaleTrials trials;
  trials.drive.drive.length = 300;
  trials.drive.drive.frames = 875;
  trials.drive.points = 900;
  trials.drive.view_limit = 30;
  trials.drive.pixel_noise = 0.2;
  trials.runs = 3;
  return trials;
}

TEST(ScaleTrials, RecoverTheScaleThatTheOdometryLost) {
  ScaleTrials trials = SmallTrials();
  trials.drive.scale_loss = 0.003;
  const std::vector<ScaleTrial> runs = RunScaleTrials(trials);
  ASSERT_EQ(runs.size(), 3U);
  for (const ScaleTrial& trial : runs) {
    EXPECT_GT(trial.odometry.ratio, 0.1);
    EXPECT_GT(trial.adjusted.ratio, 0.1);
    EXPECT_NEAR(trial.odometry.psi * kDegreesPerRadian, 0.5, 0.15);
    EXPECT_LT(trial.recovered[0].ratio, 0.03);
    EXPECT_LT(trial.adjusted.psi * kDegreesPerRadian, 0.1);
    EXPECT_TRUE(trial.converged[0]);
  }
}

TEST(ScaleTrials, DoNotDependOnTheJobs) {
  ScaleTrials trials = SmallTrials();
  const std::vector<ScaleTrial> one = RunScaleTrials(trials);
  trials.jobs = 3;
  const std::vector<ScaleTrial> three = RunScaleTrials(trials);
  ASSERT_EQ(one.size(), 3U);
  ASSERT_EQ(three.size(), 3U);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].recovered[0].ratio, three[i].recovered[0].ratio);
    EXPECT_EQ(one[i].adjusted.theta, three[i].adjusted.theta);
  }
  EXPECT_NE(one[0].recovered[0].ratio, one[1].recovered[0].ratio);
}

TEST(ScaleTrials, WhatIsToldWronglyIsDrawnOnceARun) {
  ScaleTrials trials = SmallTrials();
  trials.drive.pixel_noise = 0.02;
  trials.drive.scale_loss = 0;
  trials.told_wrong = {0.1, 0, 0};
  ScaleEstimatorSettings estimator;
  estimator.odometry.vehicle.lever_arm_sigma = 0.1;
  estimator.odometry.vehicle.side_slip_sigma = 0.001;
  trials.estimators = {estimator, estimator};
  const std::vector<ScaleTrial> runs = RunScaleTrials(trials);
  ASSERT_EQ(runs.size(), 3U);
  double largest = 0;
  for (const ScaleTrial& run : runs) {
    // The lever arm is 1 m and what is wrong of it goes into the length in full.
    EXPECT_NEAR(run.length[0].sigma, 0.1, 0.03);
    EXPECT_LT(std::abs(run.length[0].error), 4 * run.length[0].sigma);
    EXPECT_EQ(run.length[0].error, run.length[1].error) << "both estimators are told the same";
    EXPECT_GT(run.side_slip[0].sigma, 0);
    EXPECT_GE(run.side_slip[0].error, 0) << "the drive has no side slip";
    largest = std::max(largest, std::abs(run.length[0].error));
  }
  EXPECT_GT(largest, 0.02);
  EXPECT_NE(runs[0].length[0].error, runs[1].length[0].error);
}

TEST(ScaleTrials, AWrongLeverArmMakesTheScaleWrongByAsMuch) {
  ScaleTrials trials = SmallTrials();
  trials.runs = 1;
  trials.estimators.resize(2);
  *trials.estimators[1].odometry.vehicle.lever_arm *= 1.05;
  const ScaleTrial trial = RunScaleTrials(trials).front();
  EXPECT_NEAR(trial.recovered[1].ratio, 0.05, trial.recovered[0].ratio + 0.005);
}

// Each turn by itself takes the direction of travel that Q has wrong for the swing of the camera.
TEST(ScaleTrials, SmoothingFindsWhatTheCamerasYawHasWrong) {
  ScaleTrials trials = SmallTrials();
  trials.runs = 1;
  trials.estimators.resize(2);
  for (ScaleEstimatorSettings& estimator : trials.estimators)
    estimator.odometry.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.5 / kDegreesPerRadian, 0, 0});
  trials.estimators[1].odometry.scale.method = ScaleMethod::kTurns;
  const ScaleTrial trial = RunScaleTrials(trials).front();
  EXPECT_LT(trial.recovered[0].ratio, 0.5 * trial.recovered[1].ratio);
}

// Cameras that see points beside them are a hard case for the adjustment: such a point is easily left behind a camera.
TEST(ScaleTrials, ConvergeSoonWherePointsAreBesideTheCameras) {
  ScaleTrials trials = SmallTrials();
  trials.drive.within_image = false;
  trials.drive.pixel_noise = 2;
  trials.estimators[0].odometry.scale.recovery.max_iterations = 12;
  const std::vector<ScaleTrial> runs = RunScaleTrials(trials);
  ASSERT_EQ(runs.size(), 3U);
  for (const ScaleTrial& trial : runs) EXPECT_TRUE(trial.converged[0]);
}

TEST(ScaleTrials, StopWhenAsked) {
  ScaleTrials trials = SmallTrials();
  trials.progress = [](int, int) { return false; };
  EXPECT_TRUE(RunScaleTrials(trials).empty());
}

TEST(ScaleDrive, HasNineTurnsAndStepsOfTableOne) {
  const ScaleDrive drive = MakeScaleDrive({});
  EXPECT_EQ(drive.stations.size(), 389U);
  const auto centre = [&](int station) {
    return drive.truth.keyframes[drive.stations[station]].camera_from_world.inverse().translation;
  };
  EXPECT_NEAR((centre(1) - centre(0)).norm(), 3.087, 0.01);
  int turning = 0;
  for (std::size_t i = 1; i < drive.stations.size(); ++i) {
    const Eigen::Quaterniond turn = drive.truth.keyframes[drive.stations[i - 1]].camera_from_world.rotation *
                                    drive.truth.keyframes[drive.stations[i]].camera_from_world.rotation.conjugate();
    if (RotationAngle(turn) > kTurningAngle) ++turning;
  }
  EXPECT_GT(turning, 36);
  EXPECT_LT(turning, 63);
}

// What the adjustment gives must not depend on its start at the truth.
TEST(PointOdometry, GivesTheSameMotionsFromADisturbedStart) {
  ScaleDrive drive = MakeScaleDrive(SmallTrials().drive);
  const ScaleErrors from_truth = MeasureScale(drive, KeyframePoses(PointOdometry(drive)), {1, 0, 0, 0}, kTurningAngle);
  ScaleDrive disturbed = drive;
  Random random(5);
  for (Landmark& landmark : disturbed.truth.landmarks) landmark.position.y() += 0.01 * random.Gaussian();
  for (Keyframe& keyframe : disturbed.truth.keyframes) {
    if (keyframe.frame > 0) keyframe.camera_from_world.translation.x() += 0.01 * random.Gaussian();
  }
  const std::vector<RigidTransform> adjusted = KeyframePoses(PointOdometry(disturbed));
  const ScaleErrors from_there = MeasureScale(drive, adjusted, {1, 0, 0, 0}, kTurningAngle);
  EXPECT_NEAR(from_there.psi, from_truth.psi, 0.1 * from_truth.psi);
  EXPECT_NEAR(from_there.theta, from_truth.theta, 0.1 * from_truth.theta);
}

TEST(PointOdometry, LosesScaleAsItIsTold) {
  const ScaleDrive drive = MakeScaleDrive(SmallTrials().drive);
  Map map = drive.truth;
  LoseScale(0.01, 9, map);
  const auto step = [](const Map& of, int k) {
    return (of.keyframes[k].camera_from_world.inverse().translation -
            of.keyframes[k - 1].camera_from_world.inverse().translation)
        .norm();
  };
  for (const int k : {1, 40, 80}) {
    EXPECT_NEAR(step(map, k) / step(drive.truth, k), std::pow(0.99, drive.truth.keyframes[k].frame / 9.0), 1e-9);
  }
}

TEST(ScaleDrive, RefusesWhatMakesNoSense) {
  ScaleDriveOptions options;
  options.view_limit = 1;
  EXPECT_THROW(MakeScaleDrive(options), InputError);
}

}  // namespace
}  // namespace turnscale
