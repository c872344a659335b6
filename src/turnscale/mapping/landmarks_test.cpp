// SPDX-License-Identifier: MIT
#include "turnscale/mapping/landmarks.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/geometry/triangulation.h"

namespace turnscale {
namespace {

// Cameras side by side, 0.1 m apart, that look forward.
Map RowOfCameras(int count) {
  Map map;
  map.camera.pinhole = {700, 700, 600, 180};
  for (int k = 0; k < count; ++k)
    map.keyframes.push_back({k, 0.1 * k, {Eigen::Quaterniond::Identity(), {-0.1 * k, 0, 0}}, {}, false});
  return map;
}

// A landmark that all keyframes see exactly where it is.
int AddSeen(const Eigen::Vector3d& position, bool valid, Map& map) {
  const int landmark = static_cast<int>(map.landmarks.size());
  map.landmarks.push_back({position, valid, {}});
  for (size_t k = 0; k < map.keyframes.size(); ++k)
    AddObservation(map, static_cast<int>(k), landmark,
                   map.camera.pinhole.Project(map.keyframes[k].camera_from_world * position));
  return landmark;
}

bool Sees(const Map& map, int keyframe, int landmark) {
  for (const KeyframeObservation& seen : map.keyframes[keyframe].observations)
    if (seen.landmark == landmark) return true;
  return false;
}

TEST(Landmarks, GetADepthOnlyAboveTheParallax) {
  Map map = RowOfCameras(3);
  const Eigen::Vector3d near(0.5, -0.3, 10);
  const Eigen::Vector3d far(2, 1, 40);
  const int near_one = AddSeen(near, false, map);
  const int far_one = AddSeen(far, false, map);
  for (Landmark& landmark : map.landmarks) landmark.position.setZero();
  const auto parallax = [&](const Eigen::Vector3d& x) {
    return ParallaxAngle(map.keyframes[0].camera_from_world, map.keyframes[2].camera_from_world, x) * kDegreesPerRadian;
  };
  LandmarkOptions options;
  options.min_parallax = 0;
  ASSERT_GT(parallax(near), options.min_parallax_deg);
  ASSERT_LT(parallax(far), options.min_parallax_deg);
  TriangulateLandmarks(options, {near_one, far_one}, map);
  EXPECT_TRUE(map.landmarks[near_one].valid);
  EXPECT_LT((map.landmarks[near_one].position - near).norm(), 1e-9);
  EXPECT_FALSE(map.landmarks[far_one].valid);

  options.min_parallax_deg = parallax(far) * 1.001;
  TriangulateLandmarks(options, {far_one}, map);
  EXPECT_FALSE(map.landmarks[far_one].valid);
  options.min_parallax_deg = parallax(far) * 0.999;
  TriangulateLandmarks(options, {far_one}, map);
  EXPECT_TRUE(map.landmarks[far_one].valid);
  EXPECT_LT((map.landmarks[far_one].position - far).norm(), 1e-7);
}

TEST(Landmarks, AWideImageNeedsTheSamePixelsOfParallax) {
  Map map = RowOfCameras(3);
  const Eigen::Vector3d point(0.5, -0.3, 10);
  const int landmark = AddSeen(point, false, map);
  const double pixels = map.camera.pinhole.fx *
                        ParallaxAngle(map.keyframes[0].camera_from_world, map.keyframes[2].camera_from_world, point);
  LandmarkOptions options;
  options.min_parallax = 1.001 * pixels;
  TriangulateLandmarks(options, {landmark}, map);
  EXPECT_FALSE(map.landmarks[landmark].valid);
  options.min_parallax = 0.999 * pixels;
  TriangulateLandmarks(options, {landmark}, map);
  EXPECT_TRUE(map.landmarks[landmark].valid);
}

TEST(Landmarks, OnlyThoseAskedForAndWithoutADepth) {
  Map map = RowOfCameras(3);
  const int asked = AddSeen({0, 0, 5}, false, map);
  const int not_asked = AddSeen({1, 0, 5}, false, map);
  const int has_depth = AddSeen({-1, 0, 5}, true, map);
  map.landmarks[has_depth].position = {-1, 0, 5.01};
  TriangulateLandmarks({}, {asked, has_depth}, map);
  EXPECT_TRUE(map.landmarks[asked].valid);
  EXPECT_FALSE(map.landmarks[not_asked].valid);
  EXPECT_EQ(map.landmarks[has_depth].position.z(), 5.01) << "a depth that is known stays";
}

TEST(Landmarks, OneViewGivesNoDepth) {
  Map map = RowOfCameras(3);
  const int landmark = AddSeen({0, 0, 5}, false, map);
  RemoveObservation(map, 1, landmark);
  RemoveObservation(map, 2, landmark);
  TriangulateLandmarks({}, {landmark}, map);
  EXPECT_FALSE(map.landmarks[landmark].valid);
}

TEST(Landmarks, NoDepthWhereAViewBetweenDisagrees) {
  Map map = RowOfCameras(3);
  const int landmark = AddSeen({0, 0, 5}, false, map);
  map.landmarks[landmark].observations[1].pixel.y() += 2.1;
  TriangulateLandmarks({}, {landmark}, map);
  EXPECT_FALSE(map.landmarks[landmark].valid);
  map.landmarks[landmark].observations[1].pixel.y() -= 0.2;
  TriangulateLandmarks({}, {landmark}, map);
  EXPECT_TRUE(map.landmarks[landmark].valid) << "within the reprojection error it counts";
}

// What moves fast before a camera that stands seems to be very near, as the baseline is noise.
TEST(Landmarks, NoDepthFarBelowThatOfTheOthers) {
  Map map = RowOfCameras(3);
  std::vector<int> landmarks;
  for (int i = 0; i < 12; ++i) landmarks.push_back(AddSeen({0.5 * i - 3, 0.2, 100}, true, map));
  const int near_one = AddSeen({0, 0, 1.9}, false, map);
  const int other = AddSeen({0, 0, 2.1}, false, map);
  landmarks.insert(landmarks.end(), {near_one, other});
  TriangulateLandmarks({}, landmarks, map);
  EXPECT_FALSE(map.landmarks[near_one].valid);
  EXPECT_TRUE(map.landmarks[other].valid);
  TriangulateLandmarks({}, {near_one}, map);
  EXPECT_TRUE(map.landmarks[near_one].valid) << "where there are no others";
}

TEST(Landmarks, ReprojectionErrorInPixels) {
  Map map = RowOfCameras(2);
  const int landmark = AddSeen({0.2, 0.1, 5}, true, map);
  LandmarkObservation seen = map.landmarks[landmark].observations[1];
  EXPECT_NEAR(ReprojectionError(map, landmark, seen), 0, 1e-12);
  seen.pixel += Eigen::Vector2d(3, -4);
  EXPECT_NEAR(ReprojectionError(map, landmark, seen), 5, 1e-12);
  map.landmarks[landmark].position.z() = -5;
  EXPECT_EQ(ReprojectionError(map, landmark, seen), HUGE_VAL);
}

TEST(Landmarks, CullingDropsWhatContradicts) {
  Map map = RowOfCameras(4);
  const int good = AddSeen({0, 0, 5}, true, map);
  const int slipped_before = AddSeen({1, 0, 5}, true, map);
  const int slipped_now = AddSeen({-1, 0, 5}, true, map);
  const int wrong = AddSeen({0, 0.5, 5}, true, map);
  const int not_asked = AddSeen({0, -0.5, 5}, true, map);
  const int without_depth = AddSeen({0, 1, 5}, false, map);
  map.landmarks[slipped_before].observations[1].pixel.x() += 2.5;
  map.landmarks[slipped_now].observations[3].pixel.x() += 2.5;
  for (const int k : {0, 1, 3}) map.landmarks[wrong].observations[k].pixel.y() -= 30;
  map.landmarks[not_asked].observations[3].pixel.y() -= 30;
  map.landmarks[without_depth].observations[3].pixel.y() -= 30;

  const std::vector<int> lost = CullLandmarks({}, {good, slipped_before, slipped_now, wrong, without_depth}, 3, map);
  EXPECT_EQ(lost, (std::vector<int>{slipped_now, wrong}));
  EXPECT_EQ(map.landmarks[good].observations.size(), 4U);
  EXPECT_EQ(map.landmarks[slipped_before].observations.size(), 3U);
  EXPECT_FALSE(Sees(map, 1, slipped_before));
  EXPECT_TRUE(Sees(map, 3, slipped_before)) << "its track goes on";
  EXPECT_TRUE(map.landmarks[slipped_now].valid) << "the views before still agree";
  EXPECT_FALSE(Sees(map, 3, slipped_now));
  EXPECT_FALSE(map.landmarks[wrong].valid) << "one view is left";
  for (const int k : {0, 1, 2, 3}) EXPECT_FALSE(Sees(map, k, wrong));
  EXPECT_TRUE(Sees(map, 3, not_asked));
  EXPECT_TRUE(Sees(map, 3, without_depth));
}

TEST(Landmarks, ATrackThatEndedBeforeIsNotLostAgain) {
  Map map = RowOfCameras(4);
  const int landmark = AddSeen({0, 0, 5}, true, map);
  RemoveObservation(map, 3, landmark);
  map.landmarks[landmark].observations[0].pixel.x() += 5;
  EXPECT_TRUE(CullLandmarks({}, {landmark}, 3, map).empty());
  EXPECT_EQ(map.landmarks[landmark].observations.size(), 2U);
}

TEST(Landmarks, OptionsNameTheFieldThatMakesNoSense) {
  EXPECT_EQ(RefusedField<LandmarkOptions>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<LandmarkOptions>([](auto& o) { o.min_parallax_deg = 0; }), "min_parallax_deg");
  EXPECT_EQ(RefusedField<LandmarkOptions>([](auto& o) { o.min_parallax = -1; }), "min_parallax");
  EXPECT_EQ(RefusedField<LandmarkOptions>([](auto& o) { o.max_reprojection_error = std::nan(""); }),
            "max_reprojection_error");
  EXPECT_EQ(RefusedField<LandmarkOptions>([](auto& o) { o.min_distance_share = 1; }), "min_distance_share");
}

}  // namespace
}  // namespace turnscale
