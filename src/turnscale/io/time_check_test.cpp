// SPDX-License-Identifier: MIT
#include "turnscale/io/time_check.h"

#include <set>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// Straight on at 10 images a second. Steps are as long as `step` says (metres).
template <typename Step>
std::vector<FrameResult> Drive(int count, Step step) {
  std::vector<FrameResult> frames(count);
  double place = 0;
  for (int i = 0; i < count; ++i) {
    place += step(i);
    frames[i].frame = i;
    frames[i].time = 0.1 * i;
    frames[i].state = TrackingState::kTracked;
    frames[i].scale_state = ScaleState::kHeld;
    frames[i].world_from_camera = RigidTransform();
    frames[i].world_from_camera->translation.z() = place;
  }
  return frames;
}

TEST(TimeCheck, ADriveWithAllItsImagesIsFine) {
  EXPECT_TRUE(TimeWarnings({}, {}).empty());
  // Hard braking to a stop, and away again.
  EXPECT_TRUE(
      TimeWarnings(Drive(300, [](int i) { return i % 100 < 50 ? 0.02 * (50 - i % 100) : 0.01 * (i % 100 - 50); }), {})
          .empty());
}

TEST(TimeCheck, MissingImagesAreReported) {
  const std::set<int> before_missing = {20, 47, 48, 90, 140};
  auto frames = Drive(200, [&](int i) { return before_missing.contains(i) ? 2.0 : 1.0; });
  std::vector<std::string> warnings = TimeWarnings(frames, {});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("missing at 3 places at least (the first at 2.0 s)"), std::string::npos) << warnings[0];

  // Up to scale, nothing is known of speeds.
  for (FrameResult& frame : frames) frame.scale_state = ScaleState::kPending;
  EXPECT_TRUE(TimeWarnings(frames, {}).empty());
}

TEST(TimeCheck, ImagesThatAreMissingInTheTimesTooAreFine) {
  auto frames = Drive(200, [&](int i) { return i % 20 == 10 ? 2.0 : 1.0; });
  double late = 0;
  for (FrameResult& frame : frames) {
    if (frame.frame % 20 == 10) late += 0.1;
    frame.time += late;
  }
  EXPECT_TRUE(TimeWarnings(frames, {}).empty());
}

TEST(TimeCheck, NeighboursThatAreNotTrackedDoNotCount) {
  auto frames = Drive(200, [&](int i) { return i % 20 == 10 ? 2.0 : 1.0; });
  for (FrameResult& frame : frames)
    if (frame.frame % 20 == 10) frame.state = TrackingState::kBridged;
  EXPECT_TRUE(TimeWarnings(frames, {}).empty());
}

TEST(TimeCheck, TurnsThatAreTooFastAreReported) {
  const auto frames = Drive(200, [](int) { return 1.0; });
  TurnResult turn;
  turn.first_frame = 20;
  turn.last_frame = 40;
  turn.angle = -1.5;
  turn.speed = 10;
  turn.used = true;
  EXPECT_TRUE(TimeWarnings(frames, {turn}).empty());
  turn.speed = 12;
  const std::vector<std::string> warnings = TimeWarnings(frames, {turn});
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("9 m/s^2 sideways"), std::string::npos) << warnings[0];
  turn.used = false;
  EXPECT_TRUE(TimeWarnings(frames, {turn}).empty());
}

}  // namespace
}  // namespace turnscale
