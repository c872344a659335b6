// SPDX-License-Identifier: MIT
#include "turnscale/run/sigma_reason.h"

#include <gtest/gtest.h>

#include "turnscale/geometry/angle.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/test_path.h"

namespace turnscale {
namespace {

TurnResult Turn(int first, int last, double degrees, double relative_sigma) {
  TurnResult turn;
  turn.first_frame = first;
  turn.last_frame = last;
  turn.angle = degrees / kDegreesPerRadian;
  turn.used = true;
  turn.own = 2;
  turn.own_sigma = 2 * relative_sigma;
  return turn;
}

RefinedScale ScaleWith(double sigma) {
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  scale.estimate->length_sigma = sigma;
  scale.turns = {Turn(2, 5, -25, 0.18)};
  return scale;
}

std::string ReasonOf(const RefinedScale& scale, double worst = 0, const DriveFacts& drive = {}) {
  std::vector<FrameResult> frames = PathFrames(100, 1);
  for (FrameResult& frame : frames) frame.scale_sigma = scale.estimate ? scale.estimate->length_sigma : 0;
  if (worst > 0) frames.back().scale_sigma = worst;
  return SummaryOf(drive, frames, scale).scale.sigma_reason;
}

TEST(SigmaReason, NothingIsSaidOfASmallSigmaOrOfNone) {
  EXPECT_EQ(ReasonOf(ScaleWith(0.09)), "");
  EXPECT_EQ(ReasonOf({}), "");
}

TEST(SigmaReason, FewTurnsAreOne) {
  RefinedScale scale = ScaleWith(0.2);
  EXPECT_EQ(ReasonOf(scale), "only one turn is used, of 25 deg, +-18 % alone");
  scale.turns.push_back(Turn(20, 30, 40, 0.3));
  scale.turns.push_back(Turn(40, 50, 40, 0.22));
  EXPECT_EQ(ReasonOf(scale), "few turns: 3 are used, of 105 deg in all (each +-22 % alone in the median)");
  scale.turns.clear();
  EXPECT_EQ(ReasonOf(scale), "no turn is used, and the height of the camera alone tells the scale");
}

TEST(SigmaReason, WhatContributesMostIsNamedFirst) {
  RefinedScale scale = ScaleWith(0.3);
  scale.calibration_sigma = 0.2;
  EXPECT_TRUE(ReasonOf(scale).starts_with("only one turn is used")) << ReasonOf(scale);
  EXPECT_TRUE(ReasonOf(scale).ends_with("; the focal length is not known exactly")) << ReasonOf(scale);
  scale.calibration_sigma = 0.29;
  scale.contradicted_calibration.resize(1);
  EXPECT_EQ(ReasonOf(scale), "the images contradict the calibration");
  scale = ScaleWith(0.3);
  scale.estimate->uses_single_turns = true;
  scale.estimate->single_turn_spread = 0.295;
  EXPECT_EQ(ReasonOf(scale), "the turns disagree by 30 %");
  scale = ScaleWith(0.3);
  scale.unusual_height = UnusualHeight{.height = 1.05, .sigma = 0.02, .scale_error = 0.29, .is_low = true};
  EXPECT_EQ(ReasonOf(scale), "the estimated height of the camera is unusually low");
  scale = ScaleWith(0.12);
  scale.gap_sigma = 40;
  EXPECT_TRUE(ReasonOf(scale).ends_with("s of the path are not measured")) << ReasonOf(scale);
}

TEST(SigmaReason, APlaceFarFromTurnsIsOne) {
  const RefinedScale scale = ScaleWith(0.05);
  EXPECT_TRUE(ReasonOf(scale, 0.2).starts_with("at 9.9 s the nearest turn that is used is 9 s away"))
      << ReasonOf(scale, 0.2);
  EXPECT_EQ(ReasonOf(scale, 0.09), "");
}

}  // namespace
}  // namespace turnscale
