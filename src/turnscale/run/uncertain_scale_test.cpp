// SPDX-License-Identifier: MIT
#include "turnscale/run/uncertain_scale.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// Ten keyframes a second at 10 m/s; where the scale is uncertain, at `uncertain_speed`.
std::vector<FrameResult> Drive(int uncertain, double sigma, double uncertain_speed, int rest = 100) {
  std::vector<FrameResult> frames;
  double x = 0;
  for (int i = 0; i < uncertain + rest; ++i) {
    FrameResult frame;
    frame.frame = i;
    frame.time = 0.1 * i;
    frame.state = TrackingState::kTracked;
    frame.keyframe = true;
    frame.scale_state = ScaleState::kHeld;
    frame.scale_sigma = i < uncertain ? sigma : 0.02;
    x += 0.1 * (i < uncertain ? uncertain_speed : 10);
    frame.world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {x, 0, 0}};
    frames.push_back(frame);
  }
  return frames;
}

TEST(UncertainScale, ACollapsedMapLacksWhatTheCarHasDriven) {
  const std::optional<UncertainScale> part = FindUncertainScale(Drive(31, 0.6, 0.1));
  ASSERT_TRUE(part);
  EXPECT_NEAR(part->seconds, 3, 1e-9);
  EXPECT_NEAR(part->distance, 0.3, 1e-9);
  EXPECT_NEAR(part->expected, 30, 1e-9);
  EXPECT_NEAR(part->length_error(), 29.7, 1e-9);
  EXPECT_NE(UncertainScaleText(*part, 100).find("3.0 s (from 0.0 to 3.0 s)"), std::string::npos);
  EXPECT_EQ(UncertainScaleText(*part, 2000), "") << "of a long drive it is next to nothing";
}

TEST(UncertainScale, AMapAsLongAsExpectedAddsNothing) {
  EXPECT_NEAR(FindUncertainScale(Drive(31, 0.6, 10))->length_error(), 0, 1e-9);
  EXPECT_NEAR(FindUncertainScale(Drive(31, 0.6, 20))->length_error(), 30, 1e-9) << "too long";
}

TEST(UncertainScale, ASmallSigmaIsBelieved) {
  EXPECT_FALSE(FindUncertainScale(Drive(31, 0.2, 1)));
  EXPECT_FALSE(FindUncertainScale(Drive(31, 0.6, 0.1, 10))) << "too little of the drive is left to compare with";
}

TEST(UncertainScale, StandingIsNoMotion) {
  std::vector<FrameResult> frames = Drive(301, 0.6, 0);
  for (int i = 1; i < 301; ++i) frames[i].keyframe = false;
  const std::optional<UncertainScale> part = FindUncertainScale(frames);
  ASSERT_TRUE(part);
  EXPECT_NEAR(part->seconds, 3, 0.11) << "until it is clear that the car stands";
}

}  // namespace
}  // namespace turnscale
