// SPDX-License-Identifier: MIT
#include "turnscale/run/path_summary.h"

#include <vector>

#include <gtest/gtest.h>

#include "turnscale/run/test_path.h"

namespace turnscale {
namespace {

TEST(PathSummary, APathAcrossAGapIsNotMeasuredThere) {
  std::vector<FrameResult> frames = PathFrames(4, 1);
  // A minute that is not recorded.
  for (FrameResult& frame : frames) frame.time += frame.frame >= 2 ? 60 : 0;
  frames[2].world_from_camera->translation.z() += 100;
  frames[3].world_from_camera->translation.z() += 100;
  const PathSummary path = PathSummaryOf(frames);
  EXPECT_DOUBLE_EQ(path.distance, 103);
  EXPECT_DOUBLE_EQ(path.missing_distance, 101);
}

TEST(PathSummary, TheNoiseOfAStandingCarIsNoPath) {
  std::vector<FrameResult> frames = PathFrames(104, 1);
  for (FrameResult& frame : frames) {
    const bool stands = frame.frame >= 2 && frame.frame < 102;
    const double noise = frame.frame % 2 == 0 ? 0.002 : -0.002;
    frame.world_from_camera->translation.z() = stands ? 2 + noise : frame.frame < 2 ? frame.frame : frame.frame - 99;
    frame.keyframe = frame.frame < 3 || frame.frame >= 102;
  }
  const PathSummary path = PathSummaryOf(frames);
  EXPECT_NEAR(path.distance, 4, 0.01);
}

TEST(PathSummary, ACarThatTurnsBackBetweenKeyframesHasDrivenBothWays) {
  std::vector<FrameResult> frames = PathFrames(11, 1);
  for (FrameResult& frame : frames) {
    // 6 m forward and 4 m back.
    frame.world_from_camera->translation.z() = frame.frame <= 6 ? frame.frame : 12 - frame.frame;
    frame.keyframe = frame.frame == 0 || frame.frame == 10;
  }
  const PathSummary path = PathSummaryOf(frames);
  EXPECT_NEAR(path.distance, 10, 1e-9);
}

}  // namespace
}  // namespace turnscale
