// SPDX-License-Identifier: MIT
#include "turnscale/run/impossible_motion.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// Straight on at 10 images a second, at this speed (m/s) at each time.
template <typename Speed>
std::vector<FrameResult> DriveAt(double seconds, Speed speed) {
  std::vector<FrameResult> frames(static_cast<size_t>(10 * seconds));
  double place = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const double time = 0.1 * static_cast<double>(i);
    place += 0.1 * speed(time);
    frames[i].frame = static_cast<int>(i);
    frames[i].time = time;
    frames[i].state = TrackingState::kTracked;
    frames[i].scale_state = ScaleState::kHeld;
    frames[i].world_from_camera = RigidTransform();
    frames[i].world_from_camera->translation.z() = place;
  }
  return frames;
}

TEST(ImpossibleMotion, IsNoneInADrive) {
  EXPECT_TRUE(FindImpossibleMotion({}).empty());
  // Full braking to a stop, and off again.
  EXPECT_TRUE(
      FindImpossibleMotion(DriveAt(60, [](double time) {
        return time < 20 ? 30.0 : time < 23 ? 30 - 10 * (time - 20) : time < 30 ? 0.0 : std::min(4 * (time - 30), 50.0);
      })).empty());
  // A camera that froze, while the car went on or stopped.
  EXPECT_TRUE(
      FindImpossibleMotion(DriveAt(60, [](double time) { return time < 20 || time > 40 ? 10.0 : 0.0; })).empty());
}

TEST(ImpossibleMotion, IsAPartAtAnotherSpeed) {
  auto frames = DriveAt(60, [](double time) { return time > 20 && time < 30 ? 2.0 : 20.0; });
  const std::vector<ImpossibleMotion> parts = FindImpossibleMotion(frames);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_NEAR(parts[0].from, 20, 0.6);
  EXPECT_NEAR(parts[0].to, 30, 0.6);
  EXPECT_NEAR(parts[0].distance, 20, 10);
  EXPECT_NEAR(parts[0].expected, 200, 15);
  EXPECT_NEAR(LengthErrorOf(parts), 180, 15);
  EXPECT_NE(ImpossibleMotionText(parts).find("can (from 20."), std::string::npos) << ImpossibleMotionText(parts);
  for (FrameResult& frame : frames) frame.scale_state = ScaleState::kPending;
  EXPECT_TRUE(FindImpossibleMotion(frames).empty());
}

TEST(ImpossibleMotion, IsTheShorterSideOfASingleChange) {
  const auto late = FindImpossibleMotion(DriveAt(60, [](double time) { return time < 40 ? 20.0 : 5.0; }));
  ASSERT_EQ(late.size(), 1U);
  EXPECT_NEAR(late[0].from, 40, 0.6);
  EXPECT_NEAR(late[0].to, 60, 0.6);
  EXPECT_NEAR(late[0].distance, 100, 10);
  EXPECT_NEAR(late[0].expected, 400, 20);
  const auto early = FindImpossibleMotion(DriveAt(60, [](double time) { return time < 10 ? 20.0 : 5.0; }));
  ASSERT_EQ(early.size(), 1U);
  EXPECT_NEAR(early[0].from, 0, 0.1);
  EXPECT_NEAR(early[0].expected, 50, 5);
}

TEST(ImpossibleMotion, IsFasterThanACar) {
  EXPECT_TRUE(FindImpossibleMotion(DriveAt(60, [](double) { return 80.0; })).empty());
  // Although the part at the car's speed is the shorter one.
  const auto part = FindImpossibleMotion(DriveAt(60, [](double time) { return time < 20 ? 10.0 : 300.0; }));
  ASSERT_EQ(part.size(), 1U);
  EXPECT_NEAR(part[0].from, 20, 0.6);
  EXPECT_NEAR(part[0].to, 60, 0.6);
  EXPECT_NEAR(part[0].expected, 400, 20);
  EXPECT_NE(ImpossibleMotionText(part).find("the speed reaches 1080 km/h (from 19.5 to 59.5 s)"), std::string::npos)
      << ImpossibleMotionText(part);
  const auto gradual = FindImpossibleMotion(DriveAt(60, [](double time) { return 10 + 4 * time; }));
  ASSERT_EQ(gradual.size(), 1U);
  EXPECT_NEAR(gradual[0].from, 20, 1);
  EXPECT_NEAR(gradual[0].expected, 50 * 40, 100) << "the speed before it grows up to the limit";
  EXPECT_NEAR(LengthErrorOf(gradual), (170 - 50) * 40, 200);
  const auto all = FindImpossibleMotion(DriveAt(60, [](double) { return 150.0; }));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_NEAR(LengthErrorOf(all), 60 * 150, 200);
  EXPECT_EQ(ImpossibleMotionText(all).find("before and after"), std::string::npos);
}

TEST(ImpossibleMotion, PartsMayBeLongAndSeveral) {
  const auto two = FindImpossibleMotion(
      DriveAt(200, [](double time) { return (time > 40 && time < 65) || (time > 120 && time < 125) ? 2.0 : 20.0; }));
  ASSERT_EQ(two.size(), 2U);
  EXPECT_NEAR(two[0].to - two[0].from, 25, 1.1);
  EXPECT_NEAR(two[1].to - two[1].from, 5, 1.1);
  EXPECT_NEAR(LengthErrorOf(two), 25 * 18 + 5 * 18, 40);
  EXPECT_NE(ImpossibleMotionText(two).find("(2 places where no car drives so; the worst from 40."), std::string::npos);
}

TEST(ImpossibleMotion, EndsWhereTheCarStands) {
  // It stands while something passes, and drives off.
  const auto parts = FindImpossibleMotion(DriveAt(60, [](double time) {
    return time < 20 || time > 31 ? 12.0 : time < 30 ? 0.0 : 0.5;
  }));
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_LT(LengthErrorOf(parts), 20);
}

TEST(ImpossibleMotion, ALongStepIsAMatterOfTheTimes) {
  EXPECT_TRUE(
      FindImpossibleMotion(DriveAt(60, [](double time) { return std::abs(time - 30) < 0.05 ? 150.0 : 10.0; })).empty())
      << "images are missing";
  EXPECT_TRUE(
      FindImpossibleMotion(DriveAt(60, [](double time) { return std::abs(time - 30) < 0.05 ? -300.0 : 10.0; })).empty())
      << "images are repeated";
}

TEST(ImpossibleMotion, GapsHaveTimeForASpeedToChange) {
  auto frames = DriveAt(60, [](double time) { return time < 20 ? 20.0 : 2.0; });
  for (FrameResult& frame : frames)
    if (frame.time > 19 && frame.time < 22) frame.state = TrackingState::kBridged;
  EXPECT_TRUE(FindImpossibleMotion(frames).empty());
}

// Without images for two seconds from 20 s on, in which the car comes forward by this many metres.
std::vector<FrameResult> DriveWithGap(double before, double after, double way) {
  auto frames = DriveAt(60, [&](double time) { return time < 20 ? before : after; });
  const double end = frames[220].world_from_camera->translation.z();
  const double place = frames[199].world_from_camera->translation.z() + way;
  for (size_t i = 220; i < frames.size(); ++i) frames[i].world_from_camera->translation.z() += place - end;
  frames.erase(frames.begin() + 200, frames.begin() + 220);
  return frames;
}

TEST(ImpossibleMotion, MayLeadAcrossAGap) {
  for (const double way : {3.5, 8.0, 12.0})
    EXPECT_TRUE(FindImpossibleMotion(DriveWithGap(3.1, 4.2, way)).empty()) << way;
  for (const double way : {1.0, 20.0}) {
    const std::vector<ImpossibleMotion> parts = FindImpossibleMotion(DriveWithGap(3.1, 4.2, way));
    ASSERT_EQ(parts.size(), 1U) << way;
    EXPECT_NEAR(parts[0].from, 19.9, 1e-6);
    EXPECT_NEAR(parts[0].to, 22, 1e-6);
    EXPECT_NEAR(parts[0].distance, way, 1e-6);
    EXPECT_NEAR(parts[0].expected, 7.67, 0.02);
    EXPECT_NEAR(LengthErrorOf(parts), std::abs(way - 7.67), 0.02);
  }
  EXPECT_TRUE(FindImpossibleMotion(DriveWithGap(20, 20, 30)).empty()) << "firm braking";
  EXPECT_EQ(FindImpossibleMotion(DriveWithGap(20, 20, 15)).size(), 1U);
  EXPECT_TRUE(FindImpossibleMotion(DriveWithGap(20, 2, 22)).empty());
  EXPECT_TRUE(FindImpossibleMotion(DriveWithGap(0, 4, 0.5)).empty()) << "it stood";
}

}  // namespace
}  // namespace turnscale
