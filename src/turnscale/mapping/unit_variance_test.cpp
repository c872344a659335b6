// SPDX-License-Identifier: MIT
#include "turnscale/mapping/unit_variance.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/quantiles.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

constexpr int kKeyframes = 30;

Map StraightMap(double points_per_step, double pixel_noise, unsigned seed = 1) {
  const CarDrive drive = MakeCarDrive({{kKeyframes - 1, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  return MakeMap(drive, {.points_per_step = points_per_step, .pixel_noise = pixel_noise, .seed = seed});
}

TEST(UnitVariance, GrowsWithTheNoiseAndFallsWithTheLandmarks) {
  const double usual = UnitVariance(StraightMap(30, 0.3), 15).value();
  EXPECT_GT(usual, 0);
  EXPECT_NEAR(UnitVariance(StraightMap(30, 0.9), 15).value() / usual, 9, 1e-6)
      << "the same noise, three times as large";
  EXPECT_NEAR(UnitVariance(StraightMap(120, 0.3), 15).value() / usual, 0.25, 0.1);
}

TEST(UnitVariance, IsTheSameInAnyUnitOfLength) {
  Map map = StraightMap(30, 0.3);
  const double metres = UnitVariance(map, 15).value();
  for (Keyframe& keyframe : map.keyframes) keyframe.camera_from_world.translation *= 7;
  for (Landmark& landmark : map.landmarks) landmark.position *= 7;
  EXPECT_NEAR(UnitVariance(map, 15).value(), metres, 1e-9 * metres);
}

TEST(UnitVariance, IsInfiniteWhereNothingIsSeenFromBothSides) {
  Map map = StraightMap(30, 0.3);
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    const std::vector<LandmarkObservation>& seen = map.landmarks[i].observations;
    if (seen.front().keyframe < 15 && seen.back().keyframe > 15) map.landmarks[i].valid = false;
  }
  EXPECT_EQ(UnitVariance(map, 15), std::numeric_limits<double>::infinity());
  EXPECT_LT(UnitVariance(map, 5).value(), 1);
}

TEST(UnitVariance, NothingIsKnownAtAStart) {
  Map map = StraightMap(30, 0.3);
  map.keyframes[12].after_gap = true;
  EXPECT_FALSE(UnitVariance(map, -3));
  EXPECT_FALSE(UnitVariance(map, 0));
  EXPECT_FALSE(UnitVariance(map, 12));
  EXPECT_TRUE(UnitVariance(map, 15));
}

TEST(UnitVariance, IsThatOfAdjustedMaps) {
  // The first half of each map is held, the second one is adjusted: by how much its unit differs shows in the lengths.
  std::vector<double> changes;
  double expected = 0;
  constexpr int kMaps = 60;
  for (unsigned seed = 1; seed <= kMaps; ++seed) {
    const Map truth = StraightMap(8, 0.5, seed);
    BundleProblem bundle;
    bundle.pinhole = truth.pinhole;
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
    for (int k = 11; k <= 19; ++k) expected += UnitVariance(map, k).value() / kMaps;
  }
  double variance = 0;
  for (const double change : changes) variance += change * change / kMaps;
  EXPECT_GT(variance / expected, 0.25);
  EXPECT_LT(variance / expected, 4);
}

}  // namespace
}  // namespace turnscale
