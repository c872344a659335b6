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

}  // namespace
}  // namespace turnscale
