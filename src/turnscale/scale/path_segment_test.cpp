// SPDX-License-Identifier: MIT
#include "turnscale/scale/path_segment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/scale/synthetic_steps.h"

namespace turnscale {
namespace {

std::vector<VehicleStep> WithGap(std::vector<VehicleStep> steps, int at) {
  steps[at].motion = {};
  steps[at].usable = false;
  steps[at].after_gap = true;
  steps[at].gap_sigma = 0.3;
  return steps;
}

TEST(PathSegments, CoverEveryStepOnce) {
  for (const int gap : {0, 3, 90, 200}) {
    std::vector<VehicleStep> steps = MakeSteps(TownRoad(7, 2), kCar, 0, 5).steps;
    if (gap > 0) steps = WithGap(steps, gap);
    const PathSegmentOptions options;
    int next = 0;
    double length = 0;
    int turns = 0;
    for (const PathSegment& segment : SplitIntoSegments(steps, options)) {
      EXPECT_EQ(segment.first, next);
      EXPECT_GE(segment.last, segment.first);
      double own_length = 0;
      double angle = 0;
      for (int i = segment.first; i <= segment.last; ++i) {
        own_length += steps[i].motion.step;
        angle += steps[i].motion.psi;
      }
      EXPECT_NEAR(segment.length, own_length, 1e-12);
      EXPECT_NEAR(segment.angle, angle, 1e-12);
      EXPECT_NEAR(segment.middle, length + own_length / 2, 1e-9);
      EXPECT_TRUE(segment.turning || segment.last - segment.first < 2 * options.max_straight_steps);
      next = segment.last + 1;
      length += own_length;
      turns += segment.turning;
    }
    EXPECT_EQ(next, static_cast<int>(steps.size()));
    EXPECT_GE(turns, 6);
  }
}

TEST(PathSegments, AStraightMayBeCutAtEachStepOrNever) {
  const std::vector<VehicleStep> steps(50'000, VehicleStep{.motion = {.step = 1}});
  PathSegmentOptions options;
  options.max_straight_steps = std::numeric_limits<int>::max();
  ASSERT_EQ(SplitIntoSegments(steps, options).size(), 1u);
  options.max_straight_steps = 1;
  const std::vector<PathSegment> single = SplitIntoSegments(steps, options);
  ASSERT_EQ(single.size(), steps.size());
  for (int i = 0; i < static_cast<int>(single.size()); ++i) {
    ASSERT_EQ(single[i].first, i);
    ASSERT_EQ(single[i].last, i);
  }
}

TEST(PathSegments, TurnsAreThoseThatAreFound) {
  const std::vector<VehicleStep> steps = MakeSteps(TownRoad(9, 4), kCar, 0, 5).steps;
  const std::vector<TurningRegion> turns = FindTurns(steps, {});
  EXPECT_EQ(turns.size(), 9u);
  auto turn = turns.begin();
  for (const PathSegment& segment : SplitIntoSegments(steps, {})) {
    if (!segment.turning) continue;
    ASSERT_NE(turn, turns.end());
    EXPECT_EQ(segment.first, turn->first);
    EXPECT_EQ(segment.last, turn->last);
    EXPECT_NEAR(segment.angle, turn->angle, 1e-12);
    ++turn;
  }
  EXPECT_EQ(turn, turns.end());
}

TEST(PathSegments, AGapIsWhereOneBegins) {
  // On a straight, and in the middle of a turn.
  for (const int gap : {14, 40}) {
    const std::vector<VehicleStep> steps =
        WithGap(MakeSteps({{30, 0, 5, 9}, {20, 4 * kDegree, 0.5, 5}, {30, 0, 5, 9}}, kCar, 0, 5).steps, gap);
    int gaps = 0;
    int turns = 0;
    for (const PathSegment& segment : SplitIntoSegments(steps, {})) {
      EXPECT_EQ(segment.gap_sigma, segment.first == gap ? 0.3 : 0) << segment.first;
      gaps += segment.gap_sigma > 0;
      turns += segment.turning;
    }
    EXPECT_EQ(gaps, 1);
    EXPECT_EQ(turns, gap == 40 ? 2 : 1) << "no turn goes on across a gap";
  }
}

TEST(PathSegments, AStraightPartsWhereTheMapHardlyHangsTogether) {
  std::vector<VehicleStep> steps =
      MakeSteps({{30, 0, 5, 9}, {20, 4 * kDegree, 0.5, 5}, {30, 0, 5, 9}}, kCar, 0, 5).steps;
  for (VehicleStep& step : steps) step.unit_variance = 1e-6;
  steps[14].unit_variance = 0.04;
  double variance = 0;
  for (const PathSegment& segment : SplitIntoSegments(steps, {})) {
    EXPECT_NEAR(segment.gap_sigma, segment.first == 14 ? 0.2 : 0, 1e-12) << segment.first;
    variance += segment.unit_variance;
  }
  EXPECT_NEAR(variance, 79e-6, 1e-12) << "each of the other steps counts once";

  // A turn stays whole: its steps are one measurement.
  std::swap(steps[14].unit_variance, steps[40].unit_variance);
  int turns = 0;
  variance = 0;
  for (const PathSegment& segment : SplitIntoSegments(steps, {})) {
    EXPECT_EQ(segment.gap_sigma, 0) << segment.first;
    turns += segment.turning;
    variance += segment.unit_variance;
  }
  EXPECT_EQ(turns, 1);
  EXPECT_NEAR(variance, 0.04 + 79e-6, 1e-12);
}

// The whole straight decides, also for parts that show no road.
TEST(PathSegments, PartsOfAStraightThatShowsTheRoadAreMarked) {
  std::vector<VehicleStep> steps = MakeSteps({{40, 0, 5, 9}}, kCar, 0, 5).steps;
  const auto parts = [&](int shown) {
    for (int i = 0; i < 40; ++i) steps[i].height = i < shown ? 0.3 : 0;
    const std::vector<PathSegment> segments = SplitIntoSegments(steps, {});
    return std::pair(segments.size(), std::ranges::count(segments, true, &PathSegment::road_part));
  };
  EXPECT_EQ(parts(24), std::pair(std::size_t{4}, std::ptrdiff_t{4}));
  EXPECT_EQ(parts(12), std::pair(std::size_t{1}, std::ptrdiff_t{0}));
  steps.resize(9, steps.back());
  EXPECT_EQ(SplitIntoSegments(steps, {}).front().road_part, false) << "undivided";
}

TEST(PathSegments, LongStraightsAreCutEvenly) {
  const std::vector<VehicleStep> steps = MakeSteps({{100, 0, 5, 9}}, kCar, 0, 5).steps;
  const std::vector<PathSegment> segments = SplitIntoSegments(steps, {});
  ASSERT_EQ(segments.size(), 3u);
  for (const PathSegment& segment : segments) EXPECT_NEAR(segment.last - segment.first + 1, 33.3, 1);
  EXPECT_EQ(SplitIntoSegments(steps, {.turns = {}, .max_straight_steps = 100}).size(), 1u);
  EXPECT_TRUE(SplitIntoSegments({}, {}).empty());
}

TEST(PathSegments, WhatIsNotUsableEndsATurn) {
  std::vector<VehicleStep> steps = MakeSteps({{20, 4 * kDegree, 0.5, 5}}, kCar, 0, 5).steps;
  steps[9].usable = false;
  const std::vector<TurningRegion> turns = FindTurns(steps, {});
  ASSERT_EQ(turns.size(), 2u);
  EXPECT_EQ(turns[0].last, 8);
  EXPECT_EQ(turns[1].first, 10);
}

TEST(PathSegments, AJumpIsNoWay) {
  std::vector<VehicleStep> steps = MakeSteps({{20, 0.01, 5, 9}}, kCar, 0, 5).steps;
  const PathSegment smooth = SplitIntoSegments(steps, {}).at(0);
  steps[7].usable = false;
  const double length = steps[7].motion.step;
  steps[7].motion.step = 50;
  const PathSegment segment = SplitIntoSegments(steps, {}).at(0);
  EXPECT_NEAR(segment.length, smooth.length - length, 1e-12);
  EXPECT_NEAR(segment.middle, 0.5 * segment.length, 1e-12);
  EXPECT_NEAR(segment.angle, 0.19, 1e-12);
}

TEST(PathSegments, TurnsToEitherSideAddUp) {
  const PathSegment weave =
      SplitIntoSegments(MakeSteps({{5, 0.01, 5, 9}, {5, -0.01, 5, 9}}, kCar, 0, 5).steps, {}).at(0);
  EXPECT_NEAR(weave.angle, 0, 1e-12);
  EXPECT_NEAR(weave.turned, 0.1, 1e-12);
}

TEST(PathSegments, StepsOfOneAreItsSteps) {
  const std::vector<VehicleStep> steps = MakeSteps({{20, 0, 5, 9}}, kCar, 0, 5).steps;
  const std::span<const VehicleStep> some = StepsOf(steps, 4, 9);
  ASSERT_EQ(some.size(), 6u);
  EXPECT_EQ(some.front().first, steps[4].first);
  EXPECT_EQ(some.back().last, steps[9].last);
}

TEST(PathSegment, StraightsThatShowTheRoadAreCutFiner) {
  SyntheticSteps drive = MakeSteps({{80, 0, 5, 9}}, kCar, 0, kUnit);
  EXPECT_EQ(SplitIntoSegments(drive.steps, {}).size(), 2u);
  ShowRoad(1.5, {}, 1, drive);
  const std::vector<PathSegment> segments = SplitIntoSegments(drive.steps, {});
  EXPECT_EQ(segments.size(), 8u);
  EXPECT_EQ(segments.front().first, 0);
  EXPECT_EQ(segments.back().last, 79);
}

TEST(PathSegmentOptions, RefusesSenselessValues) {
  const auto refused = [](auto change) { return RefusedField<PathSegmentOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.max_straight_steps = 0; }), "max_straight_steps");
  EXPECT_EQ(refused([](auto& o) { o.turns.min_steps = 0; }), "turns.min_steps");
}

}  // namespace
}  // namespace turnscale
