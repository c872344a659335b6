// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/turn_detector.h"

#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

TurnDetectorOptions TwoDegrees() {
  TurnDetectorOptions options;
  options.min_step_angle = 2 / kDegreesPerRadian;
  return options;
}

std::vector<TurningRegion> Detect(const std::vector<double>& psi_deg,
                                  const TurnDetectorOptions& options = TwoDegrees()) {
  TurnDetector detector(options);
  std::vector<TurningRegion> regions;
  for (const double psi : psi_deg) {
    if (const auto closed = detector.Add(psi / kDegreesPerRadian)) regions.push_back(*closed);
  }
  if (const auto closed = detector.Finish()) regions.push_back(*closed);
  return regions;
}

void ExpectRegion(const TurningRegion& region, int first, int last, double angle_deg) {
  EXPECT_EQ(region.first, first);
  EXPECT_EQ(region.last, last);
  EXPECT_NEAR(region.angle * kDegreesPerRadian, angle_deg, 1e-9);
}

TEST(TurnDetector, FindsARunBetweenStraightParts) {
  const auto regions = Detect({0, 0.5, 3, 4, 5, 4, 0.5, 0.2, 0, 0});
  ASSERT_EQ(regions.size(), 1u);
  ExpectRegion(regions[0], 2, 5, 16);
}

TEST(TurnDetector, ClosesAsSoonAsTheTurnIsOver) {
  TurnDetector detector({});
  for (const double psi : {0.1, 0.1, 0.1, 0.1, 0.0}) EXPECT_FALSE(detector.Add(psi));
  const auto closed = detector.Add(0.0);
  ASSERT_TRUE(closed);
  ExpectRegion(*closed, 0, 3, 0.4 * kDegreesPerRadian);
  EXPECT_FALSE(detector.Finish());
}

TEST(TurnDetector, RunOfFewStepsIsNotATurn) { EXPECT_TRUE(Detect({0, 9, 9, 9, 0, 0}).empty()); }

TEST(TurnDetector, BendOfFewDegreesIsNotATurn) {
  EXPECT_TRUE(Detect({0, 2.5, 2.5, 2.5, 2.5, 2.5, 0, 0}).empty());
  EXPECT_EQ(Detect({0, 2.5, 2.5, 2.5, 2.5, 2.5, 2.6, 0, 0}).size(), 1u);
}

TEST(TurnDetector, WeakStepDoesNotCutATurn) {
  const std::vector<double> psi = {0, -3, -4, -4, -5, -1.8, -4, -4, -4, -4, 0, 0};
  const auto regions = Detect(psi);
  ASSERT_EQ(regions.size(), 1u);
  ExpectRegion(regions[0], 1, 9, -33.8);

  TurnDetectorOptions paper = TwoDegrees();
  paper.max_weak_steps = 0;
  const auto cut = Detect(psi, paper);
  ASSERT_EQ(cut.size(), 2u);
  ExpectRegion(cut[0], 1, 4, -16);
  ExpectRegion(cut[1], 6, 9, -16);
}

TEST(TurnDetector, TwoWeakStepsEndATurn) { EXPECT_EQ(Detect({4, 4, 4, 4, 1, 1, 4, 4, 4, 4}).size(), 2u); }

TEST(TurnDetector, WeakStepsAtTheEndStayOutside) {
  const auto regions = Detect({4, 4, 4, 4, 1});
  ASSERT_EQ(regions.size(), 1u);
  ExpectRegion(regions[0], 0, 3, 16);
}

TEST(TurnDetector, LeftThenRightIsTwoTurns) {
  for (const double between : {0.0, 4.0}) {
    const auto regions = Detect({-4, -4, -4, -4, between, 4, 4, 4, 4});
    ASSERT_EQ(regions.size(), 2u);
    ExpectRegion(regions[0], 0, 3, -16);
    ExpectRegion(regions[1], between > 0 ? 4 : 5, 8, 16 + between);
  }
}

TEST(TurnDetector, ThresholdItselfCounts) {
  TurnDetectorOptions options;
  options.min_step_angle = 0.05;
  options.min_region_angle = 0.2;
  TurnDetector detector(options);
  for (int i = 0; i < 4; ++i) detector.Add(0.05);
  EXPECT_TRUE(detector.Finish());
}

TEST(TurnDetector, LostTrackEndsATurnAndCountsAsAStep) {
  TurnDetector detector({});
  for (int i = 0; i < 4; ++i) detector.Add(0.1);
  const auto before = detector.AddUnmeasured();
  ASSERT_TRUE(before);
  EXPECT_EQ(before->last, 3);
  for (int i = 0; i < 4; ++i) detector.Add(0.1);
  const auto after = detector.Finish();
  ASSERT_TRUE(after);
  EXPECT_EQ(after->first, 5);
}

TEST(TurnDetector, ShowsTheTurnUnderWayWithoutEndingIt) {
  const std::vector<double> psi = {0, 5, 6, 1, 5, 4, 0.5, 0, 0, -5, -5, -5, -5, 3};
  // Up to the latest strong step, from the fourth strong one on.
  const std::vector<std::optional<TurningRegion>> expected = {
      {}, {}, {}, {}, {}, TurningRegion{1, 5, 21},   TurningRegion{1, 5, 21},
      {}, {}, {}, {}, {}, TurningRegion{9, 12, -20}, {}};
  TurnDetector asked(TwoDegrees());
  TurnDetector unasked(TwoDegrees());
  for (std::size_t i = 0; i < psi.size(); ++i) {
    EXPECT_EQ(asked.Add(psi[i] / kDegreesPerRadian), unasked.Add(psi[i] / kDegreesPerRadian));
    const std::optional<TurningRegion> open = asked.open();
    ASSERT_EQ(open.has_value(), expected[i].has_value()) << i;
    if (open) ExpectRegion(*open, expected[i]->first, expected[i]->last, expected[i]->angle);
    EXPECT_EQ(asked.open(), open) << "asking changes nothing";
  }
}

TEST(TurnDetector, WhatIsUnderWayIsWhatFinishGives) {
  TurnDetector detector({});
  for (const double psi : {0.1, 0.05, 0.1, 0.01, 0.1, 0.08}) detector.Add(psi);
  const std::optional<TurningRegion> open = detector.open();
  ASSERT_TRUE(open);
  EXPECT_EQ(detector.Finish(), open);
  EXPECT_FALSE(detector.open());
}

TEST(TurnDetector, ABendIsNotUnderWayAsATurn) {
  TurnDetector detector({});
  for (int i = 0; i < 5; ++i) detector.Add(0.03);
  EXPECT_FALSE(detector.open()) << "8.6 deg are too little";
  detector.AddUnmeasured();
  for (int i = 0; i < 3; ++i) detector.Add(0.2);
  EXPECT_FALSE(detector.open()) << "three steps are too few";
}

TEST(TurnDetector, ARegionBeginsNoEarlierThanWasUndecided) {
  const std::vector<double> psi = {0, 5, 0, 5, 0, 0, 5, 5, 5, 5, -4, -4, -4, -4, 0, 0};
  const std::vector<int> undecided = {1, 1, 1, 1, 1, 6, 6, 6, 6, 6, 10, 10, 10, 10, 10, 16};
  TurnDetector detector(TwoDegrees());
  int before = detector.first_undecided();
  EXPECT_EQ(before, 0);
  for (std::size_t i = 0; i < psi.size(); ++i) {
    const auto closed = detector.Add(psi[i] / kDegreesPerRadian);
    if (closed) {
      EXPECT_EQ(closed->first, before);
    }
    before = detector.first_undecided();
    EXPECT_EQ(before, undecided[i]) << i;
  }
}

TEST(TurnDetector, RefusesSenselessOptions) {
  EXPECT_THROW(TurnDetector({.min_step_angle = 0}), InputError);
  EXPECT_THROW(TurnDetector({.min_steps = 0}), InputError);
  EXPECT_THROW(TurnDetector({.max_weak_steps = -1}), InputError);
}

}  // namespace
}  // namespace turnscale
