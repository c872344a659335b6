// SPDX-License-Identifier: MIT
#include "turnscale/mapping/unit_variance.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/quantiles.h"
#include "turnscale/base/test_seeds.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

constexpr int kKeyframes = 30;
constexpr int kFollowing = 10;

Map StraightMap(double points_per_step, double pixel_noise, unsigned seed = 1) {
  const CarDrive drive = MakeCarDrive({{kKeyframes - 1, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  return MakeMap(drive, {.points_per_step = points_per_step, .pixel_noise = pixel_noise, .seed = seed});
}

TEST(UnitVariance, GrowsWithTheNoiseAndFallsWithTheLandmarks) {
  const double usual = UnitVariance(StraightMap(30, 0.3), 15, kFollowing).value();
  EXPECT_GT(usual, 0);
  EXPECT_NEAR(UnitVariance(StraightMap(30, 0.9), 15, kFollowing).value() / usual, 9, 1e-6)
      << "the same noise, three times as large";
  EXPECT_NEAR(UnitVariance(StraightMap(120, 0.3), 15, kFollowing).value() / usual, 0.25, 0.1);
}

TEST(UnitVariance, IsTheSameInAnyUnitOfLength) {
  Map map = StraightMap(30, 0.3);
  const double metres = UnitVariance(map, 15, kFollowing).value();
  for (Keyframe& keyframe : map.keyframes) keyframe.camera_from_world.translation *= 7;
  for (Landmark& landmark : map.landmarks) landmark.position *= 7;
  EXPECT_NEAR(UnitVariance(map, 15, kFollowing).value(), metres, 1e-9 * metres);
}

TEST(UnitVariance, IsInfiniteWhereNothingIsSeenFromBothSides) {
  Map map = StraightMap(30, 0.3);
  for (Landmark& landmark : map.landmarks) {
    const std::vector<LandmarkObservation>& seen = landmark.observations;
    if (seen.front().keyframe < 15 && seen.back().keyframe > 15) landmark.valid = false;
  }
  EXPECT_EQ(UnitVariance(map, 15, kFollowing), std::numeric_limits<double>::infinity());
  EXPECT_LT(UnitVariance(map, 5, kFollowing).value(), 1);
}

TEST(UnitVariance, IsNotKnownAtAStartOrShortlyBeforeAnEnd) {
  Map map = StraightMap(30, 0.3);
  EXPECT_FALSE(UnitVariance(map, -3, kFollowing));
  EXPECT_FALSE(UnitVariance(map, 0, kFollowing));
  EXPECT_TRUE(UnitVariance(map, 1, kFollowing));
  EXPECT_TRUE(UnitVariance(map, 19, kFollowing));
  EXPECT_FALSE(UnitVariance(map, 20, kFollowing));
  map.keyframes[15].after_gap = true;
  for (const int before_or_after : {5, 14, 15}) EXPECT_FALSE(UnitVariance(map, before_or_after, kFollowing));
  for (const int within : {4, 16}) EXPECT_TRUE(UnitVariance(map, within, kFollowing)) << within;
}

TEST(UnitVariance, IsThatOfAdjustedMaps) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  // Only the first two keyframes are held. How the unit of a later part differs from that of an earlier one shows in
  // the lengths of both.
  std::vector<double> changes;
  double expected = 0;
  constexpr int kMaps = 60;
  for (unsigned seed = 1; seed <= kMaps; ++seed) {
    const Map truth = StraightMap(8, 0.5, seed);
    BundleProblem bundle;
    bundle.pinhole = truth.camera.pinhole;
    for (int k = 0; k < kKeyframes; ++k) {
      bundle.camera_from_world.push_back(truth.keyframes[k].camera_from_world);
      bundle.camera_is_fixed.push_back(k < 2 ? 1 : 0);
    }
    for (const Landmark& landmark : truth.landmarks) {
      const int point = static_cast<int>(bundle.points.size());
      bundle.points.push_back(landmark.position);
      for (const LandmarkObservation& seen : landmark.observations)
        bundle.observations.push_back({seen.keyframe, point, seen.pixel, 0.5});
    }
    ASSERT_TRUE(TryAdjustBundle({}, bundle));
    Map map = truth;
    for (int k = 0; k < kKeyframes; ++k) map.keyframes[k].camera_from_world = bundle.camera_from_world[k];
    for (std::size_t i = 0; i < map.landmarks.size(); ++i) map.landmarks[i].position = bundle.points[i];
    const auto length = [](const Map& of, int first, int last) {
      return (Centre(of.keyframes[last]) - Centre(of.keyframes[first])).norm();
    };
    const double before = length(map, 8, 13) / length(truth, 8, 13);
    const double after = length(map, 17, 22) / length(truth, 17, 22);
    changes.push_back(std::log(after / before));
    for (int k = 11; k <= 19; ++k) expected += UnitVariance(map, k, kFollowing).value() / kMaps;
  }
  double variance = 0;
  for (const double change : changes) variance += change * change / kMaps;
  // The number is that of docs/scale.md.
  EXPECT_NEAR(std::sqrt(variance / expected), 1.6, 0.3);
}

}  // namespace
}  // namespace turnscale
