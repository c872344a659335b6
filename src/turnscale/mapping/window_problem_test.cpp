// SPDX-License-Identifier: MIT
#include "turnscale/mapping/window_problem.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// Five keyframes; landmark i is seen by the keyframes of seen_by[i].
Map MakeSmallMap(const std::vector<std::vector<int>>& seen_by) {
  Map map;
  map.pinhole = {700, 710, 600, 180};
  for (int k = 0; k < 5; ++k)
    map.keyframes.push_back({k, 0.1 * k, {Eigen::Quaterniond::Identity(), {0, 0, -1.0 * k}}, {}, false});
  for (size_t i = 0; i < seen_by.size(); ++i) {
    map.landmarks.push_back({Eigen::Vector3d(1.0 * static_cast<double>(i), 0, 20), true, {}});
    for (const int k : seen_by[i]) AddObservation(map, k, static_cast<int>(i), {100.0 * k, static_cast<double>(i)});
  }
  return map;
}

TEST(WindowProblem, TakesLandmarksThatFreeKeyframesSee) {
  Map map = MakeSmallMap({{3, 4}, {0, 1}, {1, 2}, {2, 3, 4}, {0, 4}, {3, 4}});
  map.landmarks[5].valid = false;
  const WindowProblem problem = MakeWindowProblem(map, {1, 3}, 0.7);
  EXPECT_EQ(problem.landmarks, (std::vector<int>{0, 3}))
      << "1 and 2 no free keyframe sees, 4 only one of the window, 5 has no depth";
  const BundleProblem& bundle = problem.bundle;
  EXPECT_EQ(bundle.pinhole.fy, 710);
  ASSERT_EQ(bundle.camera_from_world.size(), 4U);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(bundle.camera_from_world[i].translation.z(), -1.0 - i);
  EXPECT_EQ(bundle.camera_is_fixed, (std::vector<char>{1, 1, 0, 0}));
  ASSERT_EQ(bundle.points.size(), 2U);
  EXPECT_EQ(bundle.points[1].x(), 3);
  ASSERT_EQ(bundle.observations.size(), 5U);
  for (const BundleObservation& seen : bundle.observations) {
    EXPECT_EQ(seen.pixel, Eigen::Vector2d(100.0 * (seen.camera + 1), problem.landmarks[seen.point]));
    EXPECT_EQ(seen.sigma, 0.7);
  }
}

TEST(WindowProblem, AsksForEnoughViewsInTheWindow) {
  const Map map = MakeSmallMap({{3, 4}, {0, 1, 4}, {2, 3, 4}, {1, 3, 4}});
  EXPECT_EQ(MakeWindowProblem(map, {1, 2, 3}, 1).landmarks, (std::vector<int>{2, 3}));
  EXPECT_EQ(MakeWindowProblem(map, {1, 2, 2}, 1).landmarks, (std::vector<int>{0, 1, 2, 3}));
}

TEST(WindowProblem, WritesBackOnlyWhatMayMove) {
  Map map = MakeSmallMap({{3, 4}, {0, 1}});
  WindowProblem problem = MakeWindowProblem(map, {1, 3}, 1);
  ASSERT_EQ(problem.landmarks, (std::vector<int>{0}));
  for (RigidTransform& pose : problem.bundle.camera_from_world) pose.translation.x() += 7;
  problem.bundle.points[0].y() = 9;
  WriteBack(problem, map);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(map.keyframes[k].camera_from_world.translation.x(), k < 3 ? 0 : 7) << k;
  EXPECT_EQ(map.landmarks[0].position, Eigen::Vector3d(0, 9, 20));
  EXPECT_EQ(map.landmarks[1].position, Eigen::Vector3d(1, 0, 20));
}

TEST(WindowProblem, TheMapStartsAfterTheLastGap) {
  Map map = MakeSmallMap({});
  EXPECT_EQ(StartOfMap(map), 0);
  map.keyframes[1].after_gap = true;
  EXPECT_EQ(StartOfMap(map), 1);
  map.keyframes[3].after_gap = true;
  EXPECT_EQ(StartOfMap(map), 3);
  map.keyframes[4].after_gap = true;
  EXPECT_EQ(StartOfMap(map), 4);
}

}  // namespace
}  // namespace turnscale
