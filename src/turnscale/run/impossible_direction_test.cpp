// SPDX-License-Identifier: MIT
#include "turnscale/run/impossible_direction.h"

#include <vector>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kLeverArm = 1.5;
constexpr double kSpeed = 5;

// Poses of a camera at 10 images per second; the car moves by `up` and `aside` (radians) of its own axes, turns by
// `rate` (rad/s), and drives at `speed` (m/s), at each time.
template <typename Way>
std::vector<FrameResult> DriveBy(double seconds, Way way) {
  const Eigen::Quaterniond vehicle_from_camera = RotationFromYawPitchRoll({0.05, -0.1, 0.02});
  std::vector<FrameResult> frames(static_cast<size_t>(10 * seconds));
  RigidTransform world_from_vehicle;
  for (size_t i = 0; i < frames.size(); ++i) {
    FrameResult& frame = frames[i];
    frame.frame = static_cast<int>(i);
    frame.time = 0.1 * frame.frame;
    frame.state = TrackingState::kTracked;
    frame.scale_state = ScaleState::kHeld;
    frame.vehicle_from_camera = vehicle_from_camera;
    const auto [up, aside, rate, speed] = way(frame.time);
    const Eigen::Quaterniond half = RotationFromVector({0, 0.05 * rate, 0});
    world_from_vehicle.rotation = world_from_vehicle.rotation * half;
    world_from_vehicle.translation +=
        world_from_vehicle.rotation * (RotationFromYawPitchRoll({aside, up, 0}) * Eigen::Vector3d(0, 0, 0.1 * speed));
    world_from_vehicle.rotation = world_from_vehicle.rotation * half;
    frame.world_from_camera = world_from_vehicle * RigidTransform{vehicle_from_camera, {0, 0, kLeverArm}};
  }
  return frames;
}

struct Way {
  double up = 0;
  double aside = 0;
  double rate = 0;
  double speed = kSpeed;
};

TEST(ImpossibleDirection, IsNoneInADrive) {
  EXPECT_TRUE(FindImpossibleDirections({}, kLeverArm).empty());
  // A tight turn, in which the camera moves by 20 degrees to the side, and a ramp.
  const auto frames = DriveBy(40, [](double time) {
    return Way{.up = time > 20 && time < 21 ? 0.17 : 0, .rate = time > 10 && time < 13 ? kSpeed / 4 : 0};
  });
  EXPECT_TRUE(FindImpossibleDirections(frames, kLeverArm).empty());
}

TEST(ImpossibleDirection, IsAPartThatLeavesTheRoad) {
  auto frames = DriveBy(40, [](double time) { return Way{.up = time > 20 && time < 23 ? 0.6 : 0}; });
  const std::vector<ImpossibleDirection> parts = FindImpossibleDirections(frames, kLeverArm);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(parts[0].from, 20, 0.3);
  EXPECT_NEAR(parts[0].to, 23, 0.3);
  EXPECT_NEAR(parts[0].up, 0.6, 1e-6);
  EXPECT_NEAR(LengthErrorOf(parts), 3 * kSpeed, 1.5);
  const std::string text = ImpossibleDirectionText(parts, 10);
  EXPECT_NE(text.find("the path goes 34 degrees upwards as seen from the car (from 10."), std::string::npos) << text;
  EXPECT_NE(text.find(" m)"), std::string::npos) << text;
  EXPECT_EQ(ImpossibleDirectionText({}), "");
}

TEST(ImpossibleDirection, IsKnownUpToScale) {
  constexpr double kMetresPerUnit = 7;
  auto frames = DriveBy(60, [](double time) {
    return Way{.up = time > 40 && time < 43 ? 0.6 : 0, .speed = time > 5 && time < 35 ? 0.001 : kSpeed};
  });
  for (FrameResult& frame : frames) {
    frame.scale_state = ScaleState::kPending;
    frame.world_from_camera->translation /= kMetresPerUnit;
  }
  const std::vector<ImpossibleDirection> parts = FindImpossibleDirections(frames, kLeverArm);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(parts[0].from, 40, 0.6);
  EXPECT_NEAR(parts[0].to, 43, 0.6);
  EXPECT_FALSE(parts[0].distance);
  EXPECT_EQ(LengthErrorOf(parts), 0);
  const std::string text = ImpossibleDirectionText(parts);
  EXPECT_NE(text.find(" s), as no car drives"), std::string::npos) << text;
  for (FrameResult& frame : frames) frame.world_from_camera->translation.setZero();
  EXPECT_TRUE(FindImpossibleDirections(frames, kLeverArm).empty()) << "it does not move";
}

TEST(ImpossibleDirection, IsSideways) {
  const auto frames = DriveBy(
      40, [](double time) { return Way{.aside = (time > 10 && time < 12) || (time > 20 && time < 24) ? -1.4 : 0.02}; });
  const std::vector<ImpossibleDirection> parts = FindImpossibleDirections(frames, kLeverArm);
  ASSERT_EQ(parts.size(), 2U);
  const std::string text = ImpossibleDirectionText(parts);
  EXPECT_NE(text.find("degrees to the left as seen from the car (2 places, the longest from 19."), std::string::npos)
      << text;
}

TEST(ImpossibleDirection, IsRelativeToTheUsualOne) {
  const auto frames = DriveBy(40, [](double) { return Way{.up = 0.5}; });
  EXPECT_TRUE(FindImpossibleDirections(frames, kLeverArm).empty()) << "the rotation was given wrong";
  // It reverses for a while.
  const auto turned = [](double time) { return time > 20 && time < 26 ? -2.0 : 5.0; };
  EXPECT_TRUE(FindImpossibleDirections(DriveBy(40, [&](double time) { return Way{.up = 0.3, .speed = turned(time)}; }),
                                       kLeverArm)
                  .empty());
}

TEST(ImpossibleDirection, IsNotThatOfACornerAtALowRate) {
  auto frames = DriveBy(40, [](double time) { return Way{.rate = time > 10 && time < 13 ? 0.52 : 0}; });
  std::vector<FrameResult> few;
  for (size_t i = 0; i < frames.size(); i += 9) few.push_back(frames[i]);
  EXPECT_TRUE(FindImpossibleDirections(few, kLeverArm).empty());
  std::erase_if(frames, [](const FrameResult& frame) { return frame.time > 10.5 && frame.time < 12.5; });
  EXPECT_TRUE(FindImpossibleDirections(frames, kLeverArm).empty()) << "a gap in the corner";
}

TEST(ImpossibleDirection, IsNotKnownWhereThePathIsNotMeasured) {
  auto frames = DriveBy(40, [](double time) { return Way{.up = time > 20 && time < 21 ? 0.6 : 0}; });
  for (FrameResult& frame : frames)
    if (frame.time > 19.9 && frame.time < 21.1) frame.state = TrackingState::kBridged;
  EXPECT_TRUE(FindImpossibleDirections(frames, kLeverArm).empty());
}

}  // namespace
}  // namespace turnscale
