// SPDX-License-Identifier: MIT
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "odometry_run.h"
#include "street_drive.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

// Up to the end of the first turn.
constexpr int kFramesOfOneTurn = 66;

void ExpectOneTurnInMetres(const StreetDriveOptions& options) {
  const StreetDrive drive = RenderStreetDrive(options);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectMetres(run, drive);
  EXPECT_LT(std::abs(MeasureRun(run.refined, drive.world_from_camera).path_length), 0.012);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), static_cast<int>(drive.times.size()));
  ASSERT_EQ(run.turns.size(), 1U);
  EXPECT_TRUE(run.turns[0].used) << run.turns[0].reason;
  EXPECT_LT(run.map.keyframes.size(), 55U) << "as many as the motion asks for, whatever the camera";
}

TEST(OdometryCameras, EstimatedIntrinsicsAreNotTakenAsAccurate) {
  CameraModel camera = PlainStreetDrive().camera;
  EXPECT_GT(Odometry(StreetOptions(), camera).options().lens.accurate_share, 0);
  camera.focal_sigma = 5;
  EXPECT_EQ(Odometry(StreetOptions(), camera).options().lens.accurate_share, 0);
}

TEST(OdometryCameras, ThirtyFramesASecondGiveTheSameMetres) {
  ExpectOneTurnInMetres({.frames = 3 * kFramesOfOneTurn, .fps = 30});
}

TEST(OdometryCameras, OtherSizesOfTheImageGiveTheSameMetres) {
  for (const auto& [width, height] : {std::pair(640, 360), std::pair(720, 288)}) {
    SCOPED_TRACE(testing::Message() << width << " x " << height);
    ExpectOneTurnInMetres({.frames = kFramesOfOneTurn, .width = width, .height = height});
  }
}

}  // namespace
}  // namespace turnscale
