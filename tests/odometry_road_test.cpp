// SPDX-License-Identifier: MIT
#include <cmath>

#include <gtest/gtest.h>

#include "odometry_run.h"
#include "street_drive.h"

namespace turnscale {
namespace {

constexpr double kStreetCameraHeight = 1.5;  // metres

// With the height of the camera and no lever arm.
OdometryOptions HeightOnly() {
  OdometryOptions options = StreetOptions();
  options.vehicle.lever_arm.reset();
  options.vehicle.camera_height = kStreetCameraHeight;
  return options;
}

// Straight ahead, up to the first turn.
StreetDrive StraightDrive() { return PlainStreetDrive(kStreetFirstTurn); }

TEST(OdometryRoad, TheHeightGivesMetresWithoutATurn) {
  const StreetDrive drive = StraightDrive();
  const OdometryRun run = RunOdometry(HeightOnly(), drive);
  ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
  const auto length = [](const RigidTransform& first, const RigidTransform& last) {
    return (last.translation - first.translation).norm();
  };
  ASSERT_TRUE(AllPosed(run.refined));
  EXPECT_NEAR(length(*run.refined.front().world_from_camera, *run.refined.back().world_from_camera) /
                  length(drive.world_from_camera.front(), drive.world_from_camera.back()),
              1, 0.02);
  EXPECT_LT(run.scale.estimate->length_sigma, 0.03);
  EXPECT_EQ(run.refined.back().scale_state, ScaleState::kFromRoad);
  EXPECT_EQ(run.live.back().scale_state, ScaleState::kFromRoad);
  EXPECT_TRUE(run.turns.empty());
}

TEST(OdometryRoad, WithoutAHeightOrATurnTheScaleIsPending) {
  const OdometryRun run = RunOdometry(StreetOptions(), StraightDrive());
  EXPECT_FALSE(run.scale.estimate);
  EXPECT_NE(run.scale.reason.find("height"), std::string::npos) << run.scale.reason;
  EXPECT_EQ(run.live.back().scale_state, ScaleState::kPending);
}

TEST(OdometryRoad, TurnsTellTheHeight) {
  const OdometryRun run = RunOdometry(StreetOptions(), PlainStreetDrive());
  ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
  const CarRefinement& car = run.scale.estimate->car;
  EXPECT_NEAR(car.camera_height / kStreetCameraHeight, 1, 0.03);
  EXPECT_NEAR(car.camera_height, kStreetCameraHeight, 3 * car.camera_height_sigma);
  EXPECT_FALSE(run.scale.estimate->height_conflict);
}

TEST(OdometryRoad, AWrongHeightIsReported) {
  OdometryOptions options = StreetOptions();
  options.vehicle.camera_height = 1.25 * kStreetCameraHeight;
  const OdometryRun run = RunOdometry(options, PlainStreetDrive());
  ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
  ASSERT_TRUE(run.scale.estimate->height_conflict);
  EXPECT_NEAR(run.scale.estimate->height_conflict->found / kStreetCameraHeight, 1, 0.06);
}

// Their motion is that of an upright camera on a car that takes the other turns.
TEST(OdometryRoad, TellsThatImagesAreUpsideDown) {
  StreetDrive drive = PlainStreetDrive();
  EXPECT_FALSE(RunOdometry(StreetOptions(), drive).upside_down);
  for (cv::Mat& image : drive.images) {
    cv::Mat turned;
    cv::rotate(image, turned, cv::ROTATE_180);
    // The facades, which may look like a road, are out of sight.
    turned.rowRange(turned.rows * 11 / 20, turned.rows) = 128;
    image = turned;
  }
  Pinhole& pinhole = drive.camera.pinhole;
  pinhole.cx = drive.images[0].cols - 1 - pinhole.cx;
  pinhole.cy = drive.images[0].rows - 1 - pinhole.cy;
  EXPECT_TRUE(RunOdometry(StreetOptions(), drive).upside_down);
}

TEST(OdometryRoad, CanBeLeftOut) {
  OdometryOptions options = StreetOptions();
  options.road.enabled = false;
  const OdometryRun run = RunOdometry(options, PlainStreetDrive());
  ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
  EXPECT_EQ(run.scale.estimate->car.camera_height, 0);
  for (const FrameResult& frame : run.refined) EXPECT_NE(frame.scale_state, ScaleState::kFromRoad);
}

}  // namespace
}  // namespace turnscale
