// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_track.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/geometry/random_vector.h"

namespace turnscale {
namespace {

/// Three segments of two steps each, every step over three poses and 3 units; 19 poses.
struct Track {
  std::vector<VehicleStep> steps;
  ScaleEstimate estimate;
};

ScaleBelief Belief(double metres_per_unit, double sigma) {
  ScaleBelief belief;
  belief.mean[kLogScale] = std::log(metres_per_unit);
  belief.covariance(kLogScale, kLogScale) = sigma * sigma;
  return belief;
}

Track ThreeSegments() {
  Track track;
  for (int i = 0; i < 6; ++i) {
    VehicleStep step;
    step.motion.step = 3;
    step.first = 3 * i;
    step.last = 3 * i + 3;
    track.steps.push_back(step);
  }
  for (int i = 0; i < 3; ++i)
    track.estimate.segments.push_back({.first = 2 * i, .last = 2 * i + 1, .length = 6, .middle = 6.0 * i + 3});
  track.estimate.smoothed = {Belief(2, 0.1), Belief(8, 0.02), Belief(4, 0.05)};
  track.estimate.from_road = {0, 1, 0};
  return track;
}

constexpr int kPoses = 19;

TEST(ScaleTrack, GoesThroughTheMiddlesOfTheSegments) {
  const Track track = ThreeSegments();
  const std::vector<PoseScale> scales = ScaleTrack(kPoses, track.steps, track.estimate);
  ASSERT_EQ(scales.size(), static_cast<std::size_t>(kPoses));
  for (const int before_first : {0, 1, 2, 3}) {
    EXPECT_NEAR(scales[before_first].metres_per_unit, 2, 1e-12);
    EXPECT_NEAR(scales[before_first].sigma, 0.1, 1e-12);
  }
  EXPECT_NEAR(scales[9].metres_per_unit, 8, 1e-12);
  for (const int after_last : {15, 16, 18}) EXPECT_NEAR(scales[after_last].metres_per_unit, 4, 1e-12);
  // In proportion to the length, in the logarithm.
  EXPECT_NEAR(scales[6].metres_per_unit, 4, 1e-12);
  EXPECT_NEAR(scales[5].metres_per_unit, 2 * std::pow(4, 1.0 / 3), 1e-12);
  EXPECT_NEAR(scales[12].metres_per_unit, std::sqrt(32.0), 1e-12);
  EXPECT_NEAR(scales[6].sigma, 0.06, 1e-12);
}

TEST(ScaleTrack, SaysWhereTheRoadShowsTheScale) {
  const Track track = ThreeSegments();
  const std::vector<PoseScale> scales = ScaleTrack(kPoses, track.steps, track.estimate);
  for (int i = 0; i < kPoses; ++i) EXPECT_EQ(scales[i].from_road, i > 6 && i <= 12) << i;
}

TEST(ScaleTrack, StepsOfAnyLengthCountByTheirLength) {
  Track track = ThreeSegments();
  // The second step is three times as long: the way from middle to middle is 3 + 9 + ... units.
  track.steps[1].motion.step = 9;
  track.estimate.segments[0].length = 12;
  track.estimate.segments[0].middle = 6;
  track.estimate.segments[1].middle = 15;
  track.estimate.segments[2].middle = 21;
  const std::vector<PoseScale> scales = ScaleTrack(kPoses, track.steps, track.estimate);
  EXPECT_NEAR(scales[3].metres_per_unit, 2, 1e-12) << "3 units on";
  EXPECT_NEAR(scales[4].metres_per_unit, 2, 1e-12) << "6 units on";
  EXPECT_NEAR(scales[5].metres_per_unit, 2 * std::pow(4, 3.0 / 9), 1e-12) << "9 units on";
  EXPECT_NEAR(scales[9].metres_per_unit, 8, 1e-12);
}

TEST(ScaleTrack, AGapIsAJumpOfTheScale) {
  Track track = ThreeSegments();
  // Tracking is lost between poses 6 and 7, the step across has no length.
  track.steps[2] = {.motion = {}, .first = 6, .last = 7, .usable = false, .after_gap = true, .gap_sigma = 0.3};
  for (std::size_t i = 3; i < track.steps.size(); ++i) {
    track.steps[i].first -= 2;
    track.steps[i].last -= 2;
  }
  track.estimate.segments[1] = {.first = 2, .last = 3, .gap_sigma = 0.3, .length = 3, .middle = 7.5};
  track.estimate.segments[2].middle = 12;
  const std::vector<PoseScale> scales = ScaleTrack(17, track.steps, track.estimate);
  for (int i = 0; i <= 6; ++i) EXPECT_NEAR(scales[i].metres_per_unit, 2, 1e-12) << i;
  EXPECT_NEAR(scales[7].metres_per_unit, 8, 1e-12);
  EXPECT_NEAR(scales[8].metres_per_unit, 8, 1e-12);
  EXPECT_LT(scales[11].metres_per_unit, 8) << "from here on it goes to the next segment's";
  EXPECT_GT(scales[11].metres_per_unit, 4);
  EXPECT_NEAR(scales[16].metres_per_unit, 4, 1e-12);
}

TEST(ScaleTrack, PosesBeyondTheLastStepKeepItsScale) {
  const Track track = ThreeSegments();
  const std::vector<PoseScale> scales = ScaleTrack(kPoses + 4, track.steps, track.estimate);
  for (int i = kPoses; i < kPoses + 4; ++i) EXPECT_NEAR(scales[i].metres_per_unit, 4, 1e-12);
}

TEST(MetricPositions, ScalesEachStepByTheMeanOfItsEnds) {
  const std::vector<Eigen::Vector3d> positions{{1, 0, 0}, {1, 3, 0}, {1, 3, -2}};
  const std::vector<Eigen::Vector3d> metric = MetricPositions(positions, {{2, 0}, {4, 0}, {10, 0}});
  ASSERT_EQ(metric.size(), 3U);
  EXPECT_LT((metric[0] - Eigen::Vector3d(2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((metric[1] - Eigen::Vector3d(2, 9, 0)).norm(), 1e-12) << "three units at 3 metres";
  EXPECT_LT((metric[2] - Eigen::Vector3d(2, 9, -14)).norm(), 1e-12) << "two at 7";
}

TEST(MetricPositions, KeepDirectionsAndStayBetweenTheScalesOfBothEnds) {
  Random random(4);
  std::vector<Eigen::Vector3d> positions;
  std::vector<PoseScale> scales;
  for (int i = 0; i < 20; ++i) {
    positions.push_back(DrawVector<3>([&] { return random.Gaussian(); }));
    scales.push_back({random.Uniform(1, 5), 0.1});
  }
  const std::vector<Eigen::Vector3d> metric = MetricPositions(positions, scales);
  ASSERT_EQ(metric.size(), positions.size());
  EXPECT_LT((metric[0] - scales[0].metres_per_unit * positions[0]).norm(), 1e-12);
  for (std::size_t i = 1; i < metric.size(); ++i) {
    const Eigen::Vector3d step = positions[i] - positions[i - 1];
    const Eigen::Vector3d metric_step = metric[i] - metric[i - 1];
    EXPECT_LT(step.normalized().cross(metric_step).norm(), 1e-9) << "no direction changes";
    const auto [low, high] = std::minmax(scales[i - 1].metres_per_unit, scales[i].metres_per_unit);
    EXPECT_GT(metric_step.norm(), low * step.norm());
    EXPECT_LT(metric_step.norm(), high * step.norm());
  }
}

TEST(MetricPositions, OneScaleIsASimilarity) {
  const std::vector<Eigen::Vector3d> positions{{1, 2, 3}, {2, 2, 5}, {-1, 0, 4}};
  const std::vector<Eigen::Vector3d> metric = MetricPositions(positions, std::vector<PoseScale>(3, {7, 0}));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_LT((metric[i] - 7 * positions[i]).norm(), 1e-12);
}

}  // namespace
}  // namespace turnscale
