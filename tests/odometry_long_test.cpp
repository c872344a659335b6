// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "odometry_run.h"
#include "street_drive.h"
#include "street_world.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {
namespace {

constexpr int kSideFrames = 60;  // a side of the lap and the corner at its end
constexpr int kCornerFrames = 35;

// Round a block of houses, always to the right, with small images.
StreetDrive RoundTheBlock(int sides) {
  constexpr int kRampFrames = 5;
  constexpr double kStep = 0.35;  // metres a frame
  constexpr double kFar = 100;
  constexpr double kOuter = 18;
  const StreetWorld world({{{-7, -9, -7}, {7, 0, 7}},
                           {{-kFar, -8, -kFar}, {-kOuter, 0, kFar}},
                           {{kOuter, -10, -kFar}, {kFar, 0, kFar}},
                           {{-kOuter, -7, -kFar}, {kOuter, 0, -kOuter}},
                           {{-kOuter, -9, kOuter}, {kOuter, 0, kFar}}});
  StreetDrive drive;
  drive.camera = {.pinhole = {186, 186, 159.5, 63.5}, .width = 320, .height = 128};
  const std::vector<Eigen::Vector3d> rays = PixelRays(drive.camera);
  const RigidTransform vehicle_from_camera{Eigen::Quaterniond::Identity(), {0, -1.5, kStreetLeverArm}};
  RigidTransform world_from_vehicle{Eigen::Quaterniond::Identity(), {-12, 0, -4}};
  for (int frame = 0; frame < sides * kSideFrames; ++frame) {
    drive.times.push_back(kStreetInterval * frame);
    drive.world_from_camera.push_back(world_from_vehicle * vehicle_from_camera);
    drive.images.push_back(world.Render(drive.camera, rays, drive.world_from_camera.back()));
    const int corner = frame % kSideFrames - (kSideFrames - kCornerFrames);
    const double steering = std::clamp(std::min(corner + 0.5, kCornerFrames - corner - 0.5) / kRampFrames, 0.0, 1.0);
    const double psi = steering * M_PI / 2 / (kCornerFrames - kRampFrames);
    world_from_vehicle = world_from_vehicle * ConstrainedVehicleMotion({psi, kStep});
  }
  return drive;
}

// Its turns all go one way, and so does the drift of its map: twelve per cent from the first to the last.
TEST(OdometryLong, SigmaCoversADriftThatGoesOneWay) {
  constexpr int kSides = 6;
  const StreetDrive drive = RoundTheBlock(kSides);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ASSERT_TRUE(AllPosed(run.refined));
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), static_cast<int>(drive.times.size()));
  EXPECT_EQ(run.turns.size(), static_cast<size_t>(kSides));
  ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
  EXPECT_FALSE(run.scale.estimate->uses_single_turns);
  const RunErrors errors = MeasureRun(run.refined, drive.world_from_camera);
  EXPECT_LT(std::abs(errors.path_length), 0.03);
  EXPECT_LT(errors.psi_rms_deg, 0.03);
  EXPECT_LT(errors.position, 1.6);
  for (int side = 0; side < kSides; ++side) {
    double length = 0;
    double truth = 0;
    for (int i = std::max(side * kSideFrames, 1); i < (side + 1) * kSideFrames; ++i) {
      length +=
          (run.refined[i].world_from_camera->translation - run.refined[i - 1].world_from_camera->translation).norm();
      truth += (drive.world_from_camera[i].translation - drive.world_from_camera[i - 1].translation).norm();
    }
    const double sigma = run.refined[side * kSideFrames + kSideFrames / 2].scale_sigma;
    EXPECT_LT(std::abs(std::log(length / truth)), 2 * sigma) << "side " << side;
  }
}

// The archive renumbers the landmarks, which an adjusted window refers to by their numbers.
TEST(OdometryLong, KeyframesAreArchivedBetweenWindows) {
  constexpr int kSides = 3;
  const StreetDrive drive = RoundTheBlock(kSides);
  OdometryOptions options = StreetOptions();
  // The next window is due when the last one is written back.
  options.turn_bundle.window = 12;
  options.turn_bundle.anchors = 5;
  const OdometryRun run = RunOdometry(options, drive);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), static_cast<int>(drive.times.size()));
  const RunErrors errors = MeasureRun(run.refined, drive.world_from_camera);
  EXPECT_LT(std::abs(errors.path_length), 0.03);
  EXPECT_LT(errors.psi_rms_deg, 0.03);
}

}  // namespace
}  // namespace turnscale
