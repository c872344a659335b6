// SPDX-License-Identifier: MIT
#include "turnscale/run/time_check.h"

#include <cmath>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// Straight on at 10 images a second. Steps are as long as `step` says (metres); every second image has a number.
template <typename Step>
std::vector<FrameResult> Drive(int count, Step step) {
  std::vector<FrameResult> frames(count);
  double place = 0;
  for (int i = 0; i < count; ++i) {
    place += step(i);
    frames[i].frame = 2 * i;
    frames[i].time = 0.1 * i;
    frames[i].state = TrackingState::kTracked;
    frames[i].scale_state = ScaleState::kHeld;
    frames[i].world_from_camera = RigidTransform();
    frames[i].world_from_camera->translation.z() = place;
  }
  return frames;
}

// Steps of a metre, or longer where an image is missing.
std::vector<FrameResult> DriveWithLongSteps(int count, const std::set<int>& where, double length = 2) {
  return Drive(count, [&](int i) { return where.contains(i) ? length : 1.0; });
}

bool HasWarning(const std::vector<FrameResult>& frames) { return !TimeWarnings(frames, {}).empty(); }

TurnResult Turn(double speed, bool used = true) {
  TurnResult turn;
  turn.first_frame = 40;
  turn.last_frame = 80;  // 2 s later
  turn.angle = -1.5;
  turn.speed = speed;
  turn.used = used;
  return turn;
}

TEST(TimeCheck, ADriveWithAllItsImagesIsFine) {
  EXPECT_TRUE(TimeWarnings({}, {}).empty());
  // Hard braking to a stop, and away again.
  EXPECT_FALSE(HasWarning(Drive(300, [](int i) {
    const int phase = i % 100;
    return phase < 50 ? 0.02 * (50 - phase) : 0.01 * (phase - 50);
  })));
  // Creeping along, with noise as large as the steps.
  Random random(1);
  EXPECT_FALSE(HasWarning(Drive(2000, [&](int) { return 0.02 + 0.02 * random.Uniform(-1, 1); })));
}

TEST(TimeCheck, TimesOfArrivalAreReported) {
  Random random(2);
  auto frames = Drive(200, [&](int i) { return 0.8 + 0.3 * std::sin(0.05 * i) + 0.02 * random.Uniform(-1, 1); });
  EXPECT_FALSE(HasWarning(frames));
  // In bursts of five.
  for (int i = 0; i < 200; ++i) frames[i].time = 0.1 * (i - i % 5) + 0.01 * (i % 5);
  ASSERT_EQ(TimeWarnings(frames, {}).size(), 1U);
  EXPECT_NE(TimeWarnings(frames, {})[0].find("uneven"), std::string::npos);
  for (FrameResult& frame : frames) frame.scale_state = ScaleState::kPending;
  EXPECT_TRUE(HasWarning(frames)) << "up to scale, too";
  // A video of two rates, whose car goes as far as the times say.
  frames = Drive(200, [](int i) { return i % 3 == 0 ? 1.5 : 0.5; });
  for (int i = 1; i < 200; ++i) frames[i].time = frames[i - 1].time + (i % 3 == 0 ? 0.15 : 0.05);
  EXPECT_FALSE(HasWarning(frames));
}

TEST(TimeCheck, MissingImagesAreReported) {
  auto frames = DriveWithLongSteps(200, {20, 47, 48, 90, 140});
  const std::vector<std::string> warnings = TimeWarnings(frames, {});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("missing in at least 3 places (the first at 2.0 s)"), std::string::npos) << warnings[0];
  // Up to scale, nothing is known of speeds.
  for (FrameResult& frame : frames) frame.scale_state = ScaleState::kPending;
  EXPECT_FALSE(HasWarning(frames));
}

TEST(TimeCheck, AJumpBackIsReported) {
  // At 10 m/s, images of one second are repeated, twice.
  const auto jumping = Drive(200, [](int i) { return i == 80 || i == 140 ? -9.0 : 1.0; });
  const std::vector<std::string> warnings = TimeWarnings(jumping, {});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("jump back by 9.0 m at 8.0 s (the first of 2 such jumps)"), std::string::npos)
      << warnings[0];
  auto lost = Drive(200, [](int i) { return i == 80 ? -9.0 : 1.0; });
  for (int i = 79; i < 83; ++i) lost[i].state = TrackingState::kBridged;
  EXPECT_TRUE(HasWarning(lost));
  EXPECT_FALSE(HasWarning(Drive(200, [](int i) { return i < 100 ? 1.0 : -1.0; }))) << "turns round";
  EXPECT_FALSE(HasWarning(Drive(200, [](int i) { return i == 80 ? -0.3 : 0.001; }))) << "stands";
}

TEST(TimeCheck, OnlyWhereThereAreSeveral) {
  EXPECT_TRUE(HasWarning(DriveWithLongSteps(300, {20, 90, 140})));
  EXPECT_FALSE(HasWarning(DriveWithLongSteps(300, {20, 90})));
  EXPECT_FALSE(HasWarning(DriveWithLongSteps(302, {20, 90, 140}))) << "less than one in a hundred";
}

TEST(TimeCheck, OnlyStepsOfAFewImages) {
  const std::set<int> where = {20, 40, 60, 80, 100, 120};
  EXPECT_FALSE(HasWarning(DriveWithLongSteps(200, where, 1.5)));
  EXPECT_TRUE(HasWarning(DriveWithLongSteps(200, where, 1.7)));
  EXPECT_TRUE(HasWarning(DriveWithLongSteps(200, where, 3.9)));
  EXPECT_FALSE(HasWarning(DriveWithLongSteps(200, where, 4.1)));
}

TEST(TimeCheck, UnevenTimesDoNotCount) {
  // Images that are missing in the times, too.
  auto frames = Drive(200, [](int i) { return i % 20 == 10 ? 2.0 : 1.0; });
  for (FrameResult& frame : frames) {
    const int missing = (frame.frame / 2 + 10) / 20;
    frame.time += 0.1 * missing;
  }
  EXPECT_FALSE(HasWarning(frames));
  // Stamps that come late now and then, at a constant speed.
  frames = DriveWithLongSteps(200, {});
  for (FrameResult& frame : frames)
    if (frame.frame % 40 == 20) frame.time += 0.045;
  EXPECT_FALSE(HasWarning(frames));
}

TEST(TimeCheck, NeighboursThatAreNotTrackedDoNotCount) {
  auto frames = Drive(200, [](int i) { return i % 20 == 10 ? 2.0 : 1.0; });
  for (FrameResult& frame : frames)
    if (frame.frame % 40 == 20) frame.state = TrackingState::kBridged;
  EXPECT_FALSE(HasWarning(frames));
}

TEST(TimeCheck, TurnsThatAreTooFastAreReported) {
  const auto frames = DriveWithLongSteps(200, {});
  EXPECT_TRUE(TimeWarnings(frames, {Turn(7)}).empty());
  const std::vector<std::string> warnings = TimeWarnings(frames, {Turn(12)});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("9 m/s^2 sideways"), std::string::npos) << warnings[0];
  EXPECT_TRUE(TimeWarnings(frames, {Turn(12, false)}).empty());
  EXPECT_TRUE(TimeWarnings(frames, {Turn(12), Turn(5), Turn(6)}).empty()) << "one of three";
  EXPECT_FALSE(TimeWarnings(frames, {Turn(12), Turn(5), Turn(13), Turn(4, false)}).empty());
  TurnResult bend = Turn(12);
  bend.angle = 0.3;
  EXPECT_FALSE(TimeWarnings(frames, {Turn(12), bend, bend}).empty()) << "sharp turns count more";
}

TEST(TimeCheck, TurnsThatAreTooSlowAreReported) {
  const auto frames = DriveWithLongSteps(200, {});
  EXPECT_TRUE(TimeWarnings(frames, {Turn(0.2)}).empty()) << "one turn may be";
  const std::vector<std::string> warnings = TimeWarnings(frames, {Turn(0.2), Turn(0.3)});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("slow motion"), std::string::npos) << warnings[0];
  EXPECT_TRUE(TimeWarnings(frames, {Turn(0.2), Turn(1), Turn(1)}).empty()) << "one of three";
}

}  // namespace
}  // namespace turnscale
