// SPDX-License-Identifier: MIT
#include "turnscale/calibration/calibration.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

const LeverArm kArm{1.2, 0};

Calibration CalibratePath(const Trajectory& path, TravelModel travel = TravelModel::kSteady) {
  CalibrationOptions options;
  options.refinement.travel = travel;
  return Calibrate(StepsAlong(path), options);
}

TEST(Calibrate, FindsTheRotationOfAnExactDriveFromOneTurnOn) {
  for (const int side : {1, -1}) {
    for (const TravelModel travel : {TravelModel::kSteady, TravelModel::kFree}) {
      const Calibration found = CalibratePath(TestPath(TestRoute({side}), kArm, kTilted), travel);
      EXPECT_TRUE(found.observable) << found.problem;
      EXPECT_EQ(found.turns, 1);
      EXPECT_TRUE(found.refinement.converged);
      EXPECT_LT(DegreesBetween(found.vehicle_from_camera, kTilted), 1e-6);
    }
  }
}

TEST(Calibrate, FindsTheLeverArmInTheOdometrysUnit) {
  Trajectory path = TestPath(TestRoute({1, -1}), kArm, kTilted);
  for (StampedPose& pose : path) pose.world_from_camera.translation *= 0.05;
  const Calibration found = CalibratePath(path);
  ASSERT_EQ(found.refinement.lever_arms.size(), 2U);
  for (const double lever_arm : found.refinement.lever_arms) EXPECT_NEAR(lever_arm, 0.05 * 1.2, 1e-6);
}

TEST(Calibrate, StatesTheSpreadThatItsErrorsHave) {
  constexpr int kRuns = 60;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  Eigen::Vector3d stated = Eigen::Vector3d::Zero();
  CalibrationOptions options;
  options.refinement.road_bank = 0;
  options.body_lean = false;
  options.motion_bias = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Trajectory path = TestPath(TestRoute({1, -1, 1}), kArm, kTilted, 0.3 * kDeg, 100 + run);
    const Calibration found = Calibrate(StepsAlong(path), options);
    const Eigen::Vector3d error = VectorFromRotation(found.vehicle_from_camera * kTilted.conjugate());
    squares += error.cwiseAbs2();
    stated += found.covariance.diagonal();
  }
  const Eigen::Vector3d ratio = (stated.array() / squares.array()).sqrt();
  // The spread over 60 runs is itself uncertain by 9 %.
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(ratio[axis], 1, 0.25) << axis;
}

TEST(Calibrate, TurnsWithTheCamera) {
  const Trajectory path = TestPath(TestRoute({1, -1}), kArm, Eigen::Quaterniond::Identity(), 0.3 * kDeg);
  const Calibration upright = CalibratePath(path);
  Trajectory rotated = path;
  for (StampedPose& pose : rotated) pose.world_from_camera.rotation = pose.world_from_camera.rotation * kTilted;
  EXPECT_LT(DegreesBetween(CalibratePath(rotated).vehicle_from_camera, upright.vehicle_from_camera * kTilted), 1e-9);
}

TEST(Calibrate, BackingUpIsTurnedRound) {
  std::vector<CameraStep> steps = StepsAlong(TestPath(TestRoute({1, -1}), kArm, kTilted));
  for (size_t i = 0; i < steps.size() / 3; ++i) steps[i] = Reversed(steps[i]);
  const Calibration found = Calibrate(steps);
  EXPECT_EQ(found.reversed, static_cast<int>(steps.size() / 3));
  EXPECT_LT(DegreesBetween(found.vehicle_from_camera, kTilted), 1e-6);
}

TEST(Calibrate, OutliersHaveLittleSay) {
  Trajectory path = TestPath(TestRoute({1, -1, 1, -1}), kArm, kTilted, 0.05 * kDeg);
  Random random(5);
  for (StampedPose& pose : path) {
    if (random.Chance(0.02)) pose.world_from_camera.translation += Eigen::Vector3d(0.3, -0.2, 0);
  }
  EXPECT_LT(DegreesBetween(CalibratePath(path).vehicle_from_camera, kTilted), 0.04);
}

TEST(Calibrate, SideSlipDoesNotBiasIt) {
  const Calibration found = CalibratePath(TestPath(TestRoute({1, 1, -1}), {1.2, 0.005}, kTilted));
  EXPECT_LT(DegreesBetween(found.vehicle_from_camera, kTilted), 1e-6);
}

TEST(Calibrate, SaysWhatAStraightDriveLacks) {
  const Calibration found = CalibratePath(TestPath({{300, 0.8, 0}}, kArm, kTilted, 0.1 * kDeg));
  EXPECT_FALSE(found.observable);
  EXPECT_EQ(found.problem, "no turn yet: roll and yaw offset not observable");
  EXPECT_LT(found.linear.confidence, CalibrationOptions().min_confidence);
}

TEST(Calibrate, RefusesTooFewSteps) { EXPECT_THROW(Calibrate({CameraStep{}, CameraStep{}}), InputError); }

TEST(CalibrationOptions, RefuseSenselessValues) {
  using Options = CalibrationOptions;
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.min_turn = -1; }), "min_turn");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.min_confidence = 0; }), "min_confidence");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.motion_bias = -1; }), "motion_bias");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.counted_turn = 0; }), "counted_turn");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.huber_share = 0; }), "huber_share");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.road_bank = -1; }), "road_bank");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.turn_per_lever_arm = 0; }), "turn_per_lever_arm");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.max_iterations = 0; }), "max_iterations");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.refinement.tolerance = 0; }), "tolerance");
}

}  // namespace
}  // namespace turnscale
