// SPDX-License-Identifier: MIT
#include "turnscale/mapping/map.h"

#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

Map EmptyMap(int keyframes, int landmarks) {
  Map map;
  map.keyframes.resize(keyframes);
  map.landmarks.resize(landmarks);
  for (Landmark& landmark : map.landmarks) landmark.valid = true;
  return map;
}

TEST(Map, AnObservationStandsOnBothSides) {
  Map map = EmptyMap(3, 2);
  AddObservation(map, 2, 1, {3, 4});
  ASSERT_EQ(map.keyframes[2].observations.size(), 1U);
  EXPECT_EQ(map.keyframes[2].observations[0].landmark, 1);
  EXPECT_EQ(map.keyframes[2].observations[0].pixel, Eigen::Vector2d(3, 4));
  ASSERT_EQ(map.landmarks[1].observations.size(), 1U);
  EXPECT_EQ(map.landmarks[1].observations[0].keyframe, 2);
  EXPECT_EQ(map.landmarks[1].observations[0].pixel, Eigen::Vector2d(3, 4));
  EXPECT_TRUE(map.keyframes[0].observations.empty());
  EXPECT_TRUE(map.landmarks[0].observations.empty());
}

TEST(Map, TurnBetweenKeyframesIsInRadians) {
  Map map = EmptyMap(3, 0);
  map.keyframes[1].camera_from_world.rotation = RotationFromVector({0.1, 0.2, 0});
  map.keyframes[2].camera_from_world.rotation =
      RotationFromVector({0, -0.4, 0}) * map.keyframes[1].camera_from_world.rotation;
  EXPECT_NEAR(TurnBetween(map, 1, 2), 0.4, 1e-12);
  EXPECT_NEAR(TurnBetween(map, 2, 1), 0.4, 1e-12);
  EXPECT_EQ(TurnBetween(map, 0, 0), 0);
}

TEST(Map, LandmarksSeenAreValidAndEachOnce) {
  Map map = EmptyMap(4, 5);
  for (const auto& [keyframe, landmark] : {std::pair{0, 1}, {1, 4}, {1, 2}, {2, 2}, {2, 3}, {3, 0}})
    AddObservation(map, keyframe, landmark, {0, 0});
  map.landmarks[3].valid = false;
  EXPECT_EQ(LandmarksSeen(map, 1, 2), (std::vector<int>{2, 4}));
  EXPECT_EQ(LandmarksSeen(map, 0, 3), (std::vector<int>{0, 1, 2, 4}));
  EXPECT_TRUE(LandmarksSeen(map, 2, 1).empty());
}

TEST(Map, CorrectingTheLensMovesThePixelsOnBothSides) {
  Map map = EmptyMap(3, 2);
  map.camera.pinhole = {700, 700, 600, 180};
  map.camera.radial_correction = 0.01;
  AddObservation(map, 0, 1, {100, 50});
  AddObservation(map, 2, 1, {200, 300});
  AddObservation(map, 2, 0, {900, 200});
  const Map before = map;
  CorrectLens(map, -0.02);
  EXPECT_EQ(map.camera.radial_correction, -0.02);
  for (int k = 0; k < 3; ++k)
    for (size_t i = 0; i < map.keyframes[k].observations.size(); ++i)
      EXPECT_EQ(map.keyframes[k].observations[i].pixel,
                ChangeRadialCorrection(map.camera.pinhole, 0.01, -0.02, before.keyframes[k].observations[i].pixel));
  EXPECT_EQ(map.landmarks[0].observations[0].pixel, map.keyframes[2].observations[1].pixel);
  EXPECT_EQ(map.landmarks[1].observations[0].pixel, map.keyframes[0].observations[0].pixel);
  EXPECT_EQ(map.landmarks[1].observations[1].pixel, map.keyframes[2].observations[0].pixel);
}

TEST(Map, RemovingAnObservationLeavesTheOthers) {
  Map map = EmptyMap(2, 2);
  for (const int keyframe : {0, 1})
    for (const int landmark : {0, 1}) AddObservation(map, keyframe, landmark, {10.0 * keyframe, 1.0 * landmark});
  RemoveObservation(map, 0, 1);
  ASSERT_EQ(map.keyframes[0].observations.size(), 1U);
  EXPECT_EQ(map.keyframes[0].observations[0].landmark, 0);
  ASSERT_EQ(map.landmarks[1].observations.size(), 1U);
  EXPECT_EQ(map.landmarks[1].observations[0].keyframe, 1);
  EXPECT_EQ(map.keyframes[1].observations.size(), 2U);
  EXPECT_EQ(map.landmarks[0].observations.size(), 2U);
  RemoveObservation(map, 0, 1);
  EXPECT_EQ(map.keyframes[0].observations.size(), 1U) << "what is not there can not be removed twice";
}

TEST(Map, ARemovedLandmarkKeepsItsNumberAndIsSeenByNobody) {
  Map map = EmptyMap(3, 3);
  for (const int keyframe : {0, 1, 2})
    for (const int landmark : {0, 1, 2}) AddObservation(map, keyframe, landmark, {0, 0});
  RemoveLandmark(map, 1);
  ASSERT_EQ(map.landmarks.size(), 3U);
  EXPECT_FALSE(map.landmarks[1].valid);
  EXPECT_TRUE(map.landmarks[1].observations.empty());
  for (const Keyframe& keyframe : map.keyframes) {
    ASSERT_EQ(keyframe.observations.size(), 2U);
    EXPECT_EQ(keyframe.observations[0].landmark, 0);
    EXPECT_EQ(keyframe.observations[1].landmark, 2);
  }
  EXPECT_TRUE(map.landmarks[2].valid);
  EXPECT_EQ(map.landmarks[2].observations.size(), 3U);
}

}  // namespace
}  // namespace turnscale
