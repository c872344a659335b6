// SPDX-License-Identifier: MIT
#include "turnscale/run/view_change.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// Ten images a second, 100 landmarks in each; `lost` are without a pose.
std::vector<FrameResult> Frames(int count, int first_lost, int lost) {
  std::vector<FrameResult> frames(count);
  for (int i = 0; i < count; ++i) {
    frames[i].frame = i;
    frames[i].time = 5 + 0.1 * i;
    frames[i].inliers = 100;
    const bool is_lost = i >= first_lost && i < first_lost + lost;
    frames[i].tracked = is_lost ? 20 : 200;
    if (is_lost) frames[i].inliers = 5;
    frames[i].state = is_lost ? TrackingState::kBridged : TrackingState::kTracked;
    frames[i].world_from_camera = RigidTransform();
  }
  return frames;
}

TEST(ViewChange, IsFoundWhereGoodTrackingEndsAndTheMapBeginsAnew) {
  const std::vector<FrameResult> frames = Frames(60, 30, 5);
  const std::vector<double> times = FindViewChanges(frames, {{.frame = 35, .time = 8.5}});
  ASSERT_EQ(times.size(), 1U);
  EXPECT_NEAR(times[0], 8.0, 1e-9) << "of the first image of the other view";
  const std::string text = ViewChangeText(times, 5);
  EXPECT_NE(text.find("at 3.0 s,"), std::string::npos) << text;
  EXPECT_NE(ViewChangeText({6, 8}, 5).find("at 1.0 s (the first of 2 such places)"), std::string::npos);
  EXPECT_EQ(ViewChangeText({}, 5), "");
}

TEST(ViewChange, IsFoundAtLowRatesAndNotWhereClipsBegin) {
  std::vector<FrameResult> frames = Frames(60, 30, 4);
  for (FrameResult& frame : frames) frame.time = frame.frame / 3.0;
  EXPECT_EQ(FindViewChanges(frames, {{.frame = 34, .time = 34 / 3.0}}).size(), 1U);
  EXPECT_TRUE(FindViewChanges(frames, {{.frame = 34, .time = 34 / 3.0}}, {}, {10.0}).empty());
}

TEST(ViewChange, IsNoneWhereMuchIsStillFoundOrTheSceneIsHidden) {
  const MapRestart restart{.frame = 35, .time = 8.5};
  std::vector<FrameResult> dark = Frames(60, 30, 5);
  dark[30].tracked = 100;
  dark[30].inliers = 30;
  EXPECT_TRUE(FindViewChanges(dark, {restart}).empty());
  EXPECT_TRUE(FindViewChanges(Frames(60, 30, 5), {{.frame = 35, .time = 8.5, .contrast_left = 0.1}}).empty());

  // Of every second image of 60 a second, only a sample of the landmarks is looked for.
  std::vector<FrameResult> fast = Frames(300, 150, 25);
  for (FrameResult& frame : fast) frame.time = frame.frame / 60.0;
  fast[149].tracked = 60;
  fast[149].inliers = 60;
  fast[150].tracked = 70;
  EXPECT_EQ(FindViewChanges(fast, {{.frame = 175, .time = 175 / 60.0}}).size(), 1U);
  fast[148].tracked = 70;
  EXPECT_TRUE(FindViewChanges(fast, {{.frame = 175, .time = 175 / 60.0}}).empty());
}

TEST(ViewChange, IsLookedForInTheFirstImageThatIsReadableAndRepeatsNone) {
  const MapRestart restart{.frame = 35, .time = 8.5};
  std::vector<FrameResult> frames = Frames(60, 30, 5);
  for (const int i : {30, 31}) {
    frames[i].tracked = 0;
    frames[i].inliers = 0;
  }
  frames[31].state = TrackingState::kUnreadable;
  const std::vector<double> times = FindViewChanges(frames, {restart}, {30});
  ASSERT_EQ(times.size(), 1U);
  EXPECT_NEAR(times[0], 8.2, 1e-9) << "of the first image of the other view";
  frames[32].tracked = 100;
  frames[32].inliers = 30;
  EXPECT_TRUE(FindViewChanges(frames, {restart}, {30}).empty()) << "much is still found";
  EXPECT_TRUE(FindViewChanges(Frames(60, 30, 5), {restart}, {30, 31, 32, 33, 34}).empty())
      << "a frozen picture shows no other view";
}

TEST(FrozenParts, AreRepeatedImagesThatAreFollowedByAnotherView) {
  std::vector<FrameResult> frames = Frames(60, 20, 14);
  for (FrameResult& frame : frames) frame.world_from_camera->translation.z() = 0.5 * frame.frame;
  const std::vector<int> repeated = {5, 6, 7, 8, 9, 10, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29};
  const std::vector<FrozenPart> parts = FindFrozenParts(frames, repeated);
  ASSERT_EQ(parts.size(), 1U) << "the others are repeats between measured ones";
  EXPECT_NEAR(parts[0].from, 6.9, 1e-9);
  EXPECT_NEAR(parts[0].to, 8.0, 1e-9);
  EXPECT_NEAR(parts[0].length, 5.5, 1e-9);
  EXPECT_FALSE(parts[0].at_end);
  EXPECT_EQ(FrozenPartText(parts[0], 5, "m").substr(0, 42), "the picture is frozen from 1.9 s to 3.0 s:");
  frames = Frames(30, 20, 10);
  const std::vector<FrozenPart> last = FindFrozenParts(frames, {20, 21, 22, 23, 24, 25, 26, 27, 28, 29});
  ASSERT_EQ(last.size(), 1U);
  EXPECT_TRUE(last[0].at_end);
  EXPECT_NE(FrozenPartText(last[0], 5, "m").find("to the end"), std::string::npos);
  EXPECT_TRUE(FindFrozenParts({}, {3}).empty());
}

TEST(ViewChange, IsNoneWhereTrackingWasLostBitByBitOrForLong) {
  EXPECT_TRUE(FindViewChanges(Frames(60, 30, 9), {{.frame = 39, .time = 8.9}}).empty()) << "hidden for long";
  std::vector<FrameResult> fading = Frames(60, 30, 5);
  fading[29].inliers = 40;
  EXPECT_TRUE(FindViewChanges(fading, {{.frame = 35, .time = 8.5}}).empty());
  EXPECT_TRUE(FindViewChanges(Frames(60, 30, 5), {}).empty()) << "the same map goes on";
  EXPECT_TRUE(FindViewChanges({}, {{.frame = 35, .time = 8.5}}).empty());
}

}  // namespace
}  // namespace turnscale
