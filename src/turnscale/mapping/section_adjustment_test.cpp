// SPDX-License-Identifier: MIT
#include "turnscale/mapping/section_adjustment.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/geometry/similarity.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

constexpr LocalBundleOptions kOptions{.window = 60, .max_iterations = 40, .relative_cost_tolerance = 1e-7};

Map StreetMap(double pixel_noise) {
  const CarDrive drive =
      MakeCarDrive({{70, 0.8, 0}, {30, 0.8, 0.05}, {70, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  return MakeMap(drive, {.points_per_step = 20, .pixel_noise = pixel_noise});
}

// Turns, moves and stretches the world behind a keyframe, as an odometry that drifts.
void Drift(int from, double scale, Map& map) {
  const RigidTransform old_camera = map.keyframes[from].camera_from_world;
  const RigidTransform turned{RotationFromVector({0.002, 0.01, 0}), {0, 0, 0}};
  for (size_t k = from + 1; k < map.keyframes.size(); ++k) {
    RigidTransform relative = map.keyframes[k].camera_from_world * old_camera.inverse();
    relative.translation *= scale;
    map.keyframes[k].camera_from_world = relative * turned * old_camera;
  }
  for (Landmark& landmark : map.landmarks)
    if (landmark.observations.front().keyframe > from)
      landmark.position =
          old_camera.inverse() * (turned.inverse() * Eigen::Vector3d(scale * (old_camera * landmark.position)));
}

// Largest distance of a keyframe from where it should be. The unit of length is free.
double LargestError(const Map& map, const Map& truth) {
  const std::vector<Eigen::Vector3d> centres = KeyframeCentres(map);
  const std::vector<Eigen::Vector3d> wanted = KeyframeCentres(truth);
  const Similarity true_from_map = AlignPoints(centres, wanted, AlignmentModel::kSimilarity);
  double largest = 0;
  for (size_t k = 0; k < centres.size(); ++k)
    largest = std::max(largest, (true_from_map * centres[k] - wanted[k]).norm());
  return largest;
}

TEST(SectionAdjustment, TakesOutDriftAcrossSections) {
  const Map truth = StreetMap(0);
  Map map = truth;
  Drift(40, 1.1, map);
  Drift(110, 0.9, map);
  ASSERT_GT(LargestError(map, truth), 1.0);
  MapArchive archive;
  archive.Retire(CountKeyframes(map), map);
  AdjustSections(kOptions, archive, map);
  EXPECT_LT(LargestError(map, truth), 0.02) << "of 136 m";

  const ArchivedPart all = archive.Load(0, archive.end(), map);
  double largest_pixel = 0;
  for (const Keyframe& keyframe : all.map.keyframes)
    for (const KeyframeObservation& seen : keyframe.observations) {
      const Eigen::Vector3d x = keyframe.camera_from_world * all.map.landmarks[seen.landmark].position;
      largest_pixel = std::max(largest_pixel, (map.camera.pinhole.Project(x) - seen.pixel).norm());
    }
  EXPECT_LT(largest_pixel, 0.2) << "landmarks go along";
}

TEST(SectionAdjustment, RowsAreCorrectedWithTheKeyframesThatHoldASection) {
  const CarDrive drive =
      MakeCarDrive({{70, 0.8, 0}, {30, 0.8, 0.05}, {70, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  Map truth = MakeMap(drive, {.points_per_step = 20, .pixel_noise = 0, .readout = 0.02});
  const auto error = [&](double readout, bool drifts) {
    Map map = truth;
    map.camera.readout = readout;
    if (drifts) Drift(40, 1.1, map);
    if (drifts) Drift(110, 0.9, map);
    MapArchive archive;
    archive.Retire(CountKeyframes(map), map);
    AdjustSections(kOptions, archive, map);
    return LargestError(map, truth);
  };
  const double without = error(0, false);
  EXPECT_GT(without, 0.05) << "of 136 m";
  EXPECT_LT(error(0.02, false), 0.7 * without);
  EXPECT_LT(error(0.02, true), 0.7 * without) << "no speed between poses before and after their adjustment";
}

TEST(SectionAdjustment, OneSectionIsTheAdjustmentOfTheWhole) {
  Map whole = StreetMap(0.3);
  Drift(40, 1.03, whole);
  Map map = whole;
  LocalBundleOptions options = kOptions;
  options.window = 1000;
  AdjustFrom(options, 0, whole);
  MapArchive archive;
  archive.Retire(CountKeyframes(map), map);
  AdjustSections(options, archive, map);
  EXPECT_LT(LargestError(map, whole), 1e-4) << "pixels are kept in single precision";
}

TEST(SectionAdjustment, ShortSectionsHoldTheScale) {
  const Map truth = StreetMap(0);
  Map map = truth;
  Drift(40, 1.1, map);
  LocalBundleOptions options = kOptions;
  options.window = 10;
  MapArchive archive;
  // Blocks of 51 and 4 keyframes, among others.
  for (int last = 51; last < CountKeyframes(map); last += 51) archive.Retire(last, map);
  archive.Retire(CountKeyframes(map), map);
  AdjustSections(options, archive, map);
  EXPECT_LT(LargestError(map, truth), 0.5) << "of 136 m";
}

TEST(SectionAdjustment, AFewKeyframesAreASection) {
  for (const int keyframes : {1, 2, 3}) {
    Map map = StreetMap(0);
    for (int i = 0; i < static_cast<int>(map.landmarks.size()); ++i)
      if (map.landmarks[i].observations.back().keyframe >= keyframes) RemoveLandmark(map, i);
    map.keyframes.resize(keyframes);
    const Map before = map;
    MapArchive archive;
    archive.Retire(keyframes, map);
    EXPECT_EQ(AdjustSections(kOptions, archive, map), 0);
    for (int k = 0; k < keyframes; ++k)
      EXPECT_LT((Centre(map.keyframes[k]) - Centre(before.keyframes[k])).norm(), 0.01) << keyframes;
  }
}

TEST(SectionAdjustment, AKeyframeAstrayStaysAlone) {
  const Map truth = StreetMap(0);
  Map map = truth;
  map.keyframes[99].camera_from_world.translation.x() = std::nan("");
  MapArchive archive;
  archive.Retire(CountKeyframes(map), map);
  EXPECT_EQ(AdjustSections(kOptions, archive, map), 1);
  for (size_t k = 0; k < map.keyframes.size(); ++k)
    EXPECT_EQ(map.keyframes[k].camera_from_world.translation.allFinite(), k != 99) << k;
}

TEST(SectionAdjustment, WhatFollowsAGapGoesAlong) {
  const Map truth = StreetMap(0);
  Map map = truth;
  map.keyframes[100].after_gap = true;
  // Nothing is seen on both sides of a gap.
  for (size_t i = 0; i < map.landmarks.size(); ++i) {
    const auto& seen = map.landmarks[i].observations;
    if (seen.front().keyframe < 100 && seen.back().keyframe >= 100) RemoveLandmark(map, static_cast<int>(i));
  }
  Drift(40, 1.03, map);
  MapArchive archive;
  archive.Retire(CountKeyframes(map), map);
  AdjustSections(kOptions, archive, map);
  EXPECT_LT(LargestError(map, truth), 0.1);
}

}  // namespace
}  // namespace turnscale
