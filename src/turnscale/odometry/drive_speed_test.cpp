// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_speed.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kLeverArm = 1.5;

// The rear axle drives a circle at a constant speed; the camera is ahead of it and looks to the left of the car's axis.
std::vector<FrameResult> Circle(double speed, double radius, int count) {
  const Eigen::Quaterniond vehicle_from_camera = RotationFromYawPitchRoll({-0.1, 0.02, 0});
  std::vector<FrameResult> frames;
  for (int i = 0; i < count; ++i) {
    const double time = 0.1 * i;
    const double heading = speed / radius * time;
    const RigidTransform world_from_vehicle{RotationFromVector({0, heading, 0}),
                                            {radius * (1 - std::cos(heading)), 0, radius * std::sin(heading)}};
    const RigidTransform vehicle_from_camera_pose{vehicle_from_camera, {0, 0, kLeverArm}};
    FrameResult frame;
    frame.frame = i;
    frame.time = time;
    frame.state = TrackingState::kTracked;
    frame.world_from_camera = world_from_vehicle * vehicle_from_camera_pose;
    frame.vehicle_from_camera = vehicle_from_camera;
    frame.scale_state = ScaleState::kHeld;
    frame.scale_sigma = 0.02;
    frames.push_back(frame);
  }
  return frames;
}

TEST(DriveSpeed, IsThatOfTheRearAxle) {
  for (const double speed : {5.0, -1.0}) {
    const std::vector<SpeedReading> speeds = SpeedsOf(Circle(speed, 6, 100), kLeverArm);
    ASSERT_EQ(speeds.size(), 100u);
    for (size_t i = 5; i < 95; ++i) {
      EXPECT_NEAR(speeds[i].speed, speed, 0.01) << i;
      EXPECT_NEAR(speeds[i].sigma, 0.02 * std::abs(speed), 0.01) << i;
    }
  }
}

TEST(DriveSpeed, NeedsMetresAndMeasuredPoses) {
  std::vector<FrameResult> frames = Circle(5, 20, 30);
  for (int i = 0; i < 4; ++i) frames[i].state = TrackingState::kInitializing;
  EXPECT_EQ(SpeedsOf(frames, kLeverArm).size(), 26u);
  EXPECT_NEAR(SpeedsOf(frames, kLeverArm).front().time, 0.4, 1e-12);
  for (FrameResult& frame : frames) frame.scale_state = ScaleState::kPending;
  EXPECT_TRUE(SpeedsOf(frames, kLeverArm).empty());
  EXPECT_TRUE(SpeedsOf({}, kLeverArm).empty());
}

}  // namespace
}  // namespace turnscale
