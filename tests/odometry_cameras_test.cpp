// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <gtest/gtest.h>

#include "odometry_run.h"
#include "street_drive.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

// Up to the end of the first turn.
constexpr int kFramesOfOneTurn = 66;

OdometryRun ExpectOneTurnInMetres(const StreetDrive& drive) {
  OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectMetres(run, drive);
  EXPECT_LT(std::abs(MeasureRun(run.refined, drive.world_from_camera).path_length), 0.012);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), static_cast<int>(drive.times.size()));
  EXPECT_EQ(run.turns.size(), 1U);
  for (const TurnResult& turn : run.turns) EXPECT_TRUE(turn.used) << turn.reason;
  EXPECT_LT(run.map.keyframes.size(), 55U) << "as many as the motion asks for, whatever the camera";
  return run;
}

// Every other image of a drive.
StreetDrive HalfTheRate(const StreetDrive& drive) {
  StreetDrive half = {.camera = drive.camera, .times = {}, .world_from_camera = {}, .images = {}};
  for (size_t i = 0; i < drive.times.size(); i += 2) {
    half.times.push_back(drive.times[i]);
    half.world_from_camera.push_back(drive.world_from_camera[i]);
    half.images.push_back(drive.images[i]);
  }
  return half;
}

TEST(OdometryCameras, EstimatedIntrinsicsAreNotTakenAsAccurate) {
  CameraModel camera = PlainStreetDrive().camera;
  EXPECT_GT(Odometry(StreetOptions(), camera).options().lens.accurate_share, 0);
  camera.focal_sigma = 5;
  EXPECT_EQ(Odometry(StreetOptions(), camera).options().lens.accurate_share, 0);
}

TEST(OdometryCameras, ThirtyAndSixtyFramesASecondGiveTheSameMetres) {
  const StreetDrive drive = RenderStreetDrive({.frames = 6 * kFramesOfOneTurn, .fps = 60});
  const OdometryRun all = ExpectOneTurnInMetres(drive);
  ExpectOneTurnInMetres(HalfTheRate(drive));
  // At least as many landmarks are tracked where not only a sample is.
  constexpr int kSample = 120;
  const auto samples =
      std::ranges::count_if(all.live, [](const FrameResult& frame) { return frame.tracked <= kSample; });
  EXPECT_NEAR(static_cast<double>(samples), 0.5 * static_cast<double>(all.live.size()), 20);
}

TEST(OdometryCameras, OtherSizesOfTheImageGiveTheSameMetres) {
  for (const auto& [width, height] : {std::pair(640, 360), std::pair(720, 288)}) {
    SCOPED_TRACE(testing::Message() << width << " x " << height);
    ExpectOneTurnInMetres(RenderStreetDrive({.frames = kFramesOfOneTurn, .width = width, .height = height}));
  }
}

// In the turn, the car turns by more than a degree while the rows of an image are read.
TEST(OdometryCameras, ARollingShutterIsFoundInTurnsAndCorrected) {
  constexpr double kReadout = 0.04;
  const StreetDrive drive = RenderStreetDrive({.frames = kFramesOfOneTurn, .readout = kReadout});
  const OdometryRun corrected = RunOdometry(StreetOptions(), drive);
  ASSERT_TRUE(corrected.scale.readout);
  EXPECT_NEAR(corrected.scale.readout->seconds, kReadout, 2 * corrected.scale.readout->sigma);
  EXPECT_LT(corrected.scale.readout->sigma, 0.1 * kReadout);
  EXPECT_TRUE(corrected.scale.readout->is_corrected);
  EXPECT_TRUE(corrected.scale.contradicted_calibration.empty());
  OdometryOptions global = StreetOptions();
  global.calibration_check.readout_prior_sigma = 1e-6;
  const OdometryRun uncorrected = RunOdometry(global, drive);
  EXPECT_FALSE(uncorrected.scale.readout);
  const double shape = MeasureRun(corrected.refined, drive.world_from_camera).shape;
  EXPECT_LT(shape, 0.5 * MeasureRun(uncorrected.refined, drive.world_from_camera).shape);
}

// The first frames have no turn of which a readout could be read.
TEST(OdometryCameras, AReadoutThatIsKnownIsCorrectedWithoutATurn) {
  CameraModel camera = PlainStreetDrive(20).camera;
  const StreetDrive drive = PlainStreetDrive(20);
  camera.readout = 0.02;
  camera.readout_sigma = 0.001;
  const OdometryRun run = RunOdometry(StreetOptions(), camera, drive.images, drive.times);
  ASSERT_TRUE(run.scale.readout);
  EXPECT_EQ(run.scale.readout->seconds, 0.02);
  EXPECT_TRUE(run.scale.readout->is_corrected);
}

// Of a camera that has another than the file says.
TEST(OdometryCameras, AReadoutThatTheTurnsContradictIsReported) {
  const StreetDrive drive = PlainStreetDrive();
  CameraModel camera = drive.camera;
  camera.readout = 0.04;
  camera.readout_sigma = 0.001;
  const OdometryRun run = RunOdometry(StreetOptions(), camera, drive.images, drive.times);
  EXPECT_TRUE(run.scale.contradicted_calibration.empty());
  ASSERT_TRUE(run.scale.contradicted_readout);
  EXPECT_EQ(run.scale.contradicted_readout->given, 0.04);
  EXPECT_NEAR(run.scale.contradicted_readout->found, 0, 0.004);
  EXPECT_FALSE(run.scale.readout) << "a global shutter";
}

}  // namespace
}  // namespace turnscale
