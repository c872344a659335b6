// SPDX-License-Identifier: MIT
#include "turnscale/odometry/tracking_loss.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

constexpr TrackingOptions kLimits;
constexpr double kStopped = 1.4;  // when the motion was measured last, or broke off, seconds

// Ten images a second until kStopped, one unit of length apart.
MotionModel Driving() {
  MotionModel motion;
  for (int i = 0; i < 5; ++i) motion.Update(1 + 0.1 * i, {Eigen::Quaterniond::Identity(), {0, 0, -1.0 * i}});
  return motion;
}

// Three seconds of repeated images follow, and an image that is tracked where the camera was before.
constexpr double kTrackedAgain = kStopped + 3;
MotionModel Frozen() {
  MotionModel motion = Driving();
  motion.Update(kTrackedAgain, motion.last(), true);
  return motion;
}

cv::Mat Gray(int level) { return {1, 1, CV_8U, cv::Scalar(level)}; }

TrackingLoss Lost(int images) {
  TrackingLoss loss(kLimits);
  loss.AddTracked(kStopped);
  for (int i = 0; i < images; ++i) loss.AddLost(Gray(i));
  return loss;
}

TEST(TrackingLoss, TheMapIsGivenUpAfterAFewImagesAndSomeTime) {
  const MotionModel motion = Driving();
  const double patience = kStopped + kLimits.max_lost_seconds;
  EXPECT_FALSE(Lost(kLimits.min_lost_frames).GivesUp(motion, false, patience - 0.01));
  EXPECT_TRUE(Lost(kLimits.min_lost_frames).GivesUp(motion, false, patience + 0.01));
  EXPECT_FALSE(Lost(kLimits.min_lost_frames - 1).GivesUp(motion, false, patience + 0.01));
}

TEST(TrackingLoss, OnlyImagesThatWereNotTrackedCount) {
  TrackingLoss loss = Lost(kLimits.min_lost_frames - 1);
  loss.AddUnreadable();
  EXPECT_FALSE(loss.GivesUp(Driving(), false, kStopped + 1)) << "there was no image";
  loss.AddTracked(kStopped);
  loss.AddLost(Gray(9));
  EXPECT_FALSE(loss.GivesUp(Driving(), false, kStopped + 1)) << "one was tracked in between";
}

TEST(TrackingLoss, WhatPassesBeforeACarThatStandsHidesTheSceneForLonger) {
  const TrackingLoss loss = Lost(kLimits.min_lost_frames);
  EXPECT_FALSE(loss.GivesUp(Driving(), true, kStopped + kLimits.max_hidden_seconds - 0.01));
  EXPECT_TRUE(loss.GivesUp(Driving(), true, kStopped + kLimits.max_hidden_seconds + 0.01));
}

TEST(TrackingLoss, NothingPassesWhereNoPixelHadChanged) {
  const double lost = kTrackedAgain + kLimits.max_lost_seconds + 0.01;
  TrackingLoss loss = Lost(kLimits.min_lost_frames);
  EXPECT_FALSE(loss.GivesUp(Frozen(), true, lost));
  loss.AddSamePixels(kTrackedAgain);
  EXPECT_TRUE(loss.GivesUp(Frozen(), true, lost));
  EXPECT_FALSE(loss.GivesUp(Driving(), true, lost)) << "the car braked";
}

TEST(TrackingLoss, KeepsTheFirstImageThatWasNotTracked) {
  EXPECT_TRUE(Lost(0).first_lost().empty());
  TrackingLoss loss = Lost(3);
  EXPECT_EQ(loss.first_lost().at<uchar>(0), 0);
  loss.AddTracked(2);
  loss.AddLost(Gray(9));
  EXPECT_EQ(loss.first_lost().at<uchar>(0), 9);
}

TEST(TrackingLoss, ARepeatIsSeenButNotTracked) {
  TrackingLoss loss(kLimits);
  EXPECT_FALSE(loss.AddTracked(1));
  loss.AddRepeat(2);
  EXPECT_EQ(loss.last_seen_time(), 2);
  EXPECT_TRUE(loss.AddTracked(3));
  EXPECT_FALSE(loss.AddTracked(4));
  loss.AddRepeat(5);
  loss.AddLost(Gray(0));
  EXPECT_EQ(loss.last_seen_time(), 5);
  EXPECT_FALSE(loss.AddTracked(6)) << "another view came in between";
}

TEST(TrackingLoss, ACarDoesNotStopFromOneImageToTheNext) {
  EXPECT_FALSE(FrozenSince(Driving(), kStopped + 3));
  ASSERT_TRUE(FrozenSince(Frozen(), kTrackedAgain));
  EXPECT_NEAR(*FrozenSince(Frozen(), kTrackedAgain), kStopped, 1e-9);
  EXPECT_FALSE(FrozenSince(Frozen(), kStopped + 16)) << "it stands after all";
}

TEST(TrackingLoss, ADriveCanEndFrozen) {
  TrackingLoss loss(kLimits);
  EXPECT_FALSE(loss.FrozenAtEnd(Driving(), kStopped + 2)) << "no image repeats another";
  ASSERT_TRUE(loss.FrozenAtEnd(Frozen(), kTrackedAgain));
  EXPECT_NEAR(*loss.FrozenAtEnd(Frozen(), kTrackedAgain), kStopped, 1e-9);
  loss.AddRepeat(kStopped + 2);
  ASSERT_TRUE(loss.FrozenAtEnd(Driving(), kStopped + 2));
  EXPECT_NEAR(*loss.FrozenAtEnd(Driving(), kStopped + 2), kStopped, 1e-9);
  EXPECT_FALSE(loss.FrozenAtEnd(Driving(), kStopped + 0.5)) << "too short to tell";
}

}  // namespace
}  // namespace turnscale
