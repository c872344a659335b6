// SPDX-License-Identifier: MIT
#include "turnscale/odometry/road_heights.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Keyframes half a unit apart, straight ahead.
Map StraightMap(int keyframes) {
  Map map;
  for (int k = 0; k < keyframes; ++k)
    map.keyframes.push_back({k, 0.1 * k, {Eigen::Quaterniond::Identity(), {0, 0, -0.5 * k}}, {}, false});
  return map;
}

MeasuredHeight Measured(int keyframe, int reference, double ratio, double sigma) {
  MeasuredHeight height;
  height.keyframe = keyframe;
  height.reference = reference;
  height.ratio = ratio;
  height.sigma = sigma;
  return height;
}

VehicleStep StepBetween(int first, int last) {
  VehicleStep step;
  step.first = first;
  step.last = last;
  return step;
}

TEST(RoadHeights, AStepHasTheHeightOfItsKeyframes) {
  const Map map = StraightMap(10);
  // 0.4 units each, but for one outside of the step.
  const std::vector<MeasuredHeight> heights = {Measured(3, 2, 9.0, 0.01), Measured(4, 3, 0.8, 0.01),
                                               Measured(6, 4, 0.4, 0.02), Measured(7, 6, 9.0, 0.01)};
  VehicleStep step = StepBetween(3, 6);
  SetStepHeight(map, heights, step);
  EXPECT_NEAR(step.height, 0.4, 1e-12);
  EXPECT_GT(step.height_sigma, 0.01) << "they share their errors";
  EXPECT_LT(step.height_sigma, 0.02);
}

TEST(RoadHeights, FollowTheMapWhenItIsAdjusted) {
  Map map = StraightMap(10);
  const std::vector<MeasuredHeight> heights = {Measured(4, 2, 0.4, 0.01)};
  VehicleStep before = StepBetween(3, 6);
  SetStepHeight(map, heights, before);
  for (Keyframe& keyframe : map.keyframes) keyframe.camera_from_world.translation *= 1.1;
  VehicleStep after = StepBetween(3, 6);
  SetStepHeight(map, heights, after);
  EXPECT_NEAR(after.height, 1.1 * before.height, 1e-12);
}

TEST(RoadHeights, FollowAChangeOfTheMotion) {
  Map map = StraightMap(10);
  // The later keyframe turns down by 2 mrad and rises by 1 mrad of the way when the map is adjusted.
  MeasuredHeight height = Measured(4, 2, 0.4, 0.01);
  height.reference_from_keyframe = map.keyframes[2].camera_from_world * map.keyframes[4].camera_from_world.inverse();
  height.by_rotation << -4, 0.5, 0.2;
  height.by_direction << 0.1, 6, 0;
  VehicleStep before = StepBetween(3, 6);
  SetStepHeight(map, {height}, before);
  EXPECT_NEAR(before.height, 0.4, 1e-12);
  const RigidTransform pose = map.keyframes[4].camera_from_world.inverse();
  const RigidTransform adjusted{RotationFromVector({-0.002, 0, 0}) * pose.rotation,
                                pose.translation + Eigen::Vector3d(0, -0.001, 0)};
  map.keyframes[4].camera_from_world = adjusted.inverse();
  VehicleStep after = StepBetween(3, 6);
  SetStepHeight(map, {height}, after);
  EXPECT_NEAR(std::log(after.height / before.height), 4 * 0.002 - 6 * 0.001, 1e-5);
}

TEST(RoadHeights, TooLargeAChangeOfTheMotionLeavesNoHeight) {
  Map map = StraightMap(10);
  MeasuredHeight height = Measured(4, 2, 0.4, 0.01);
  height.reference_from_keyframe = map.keyframes[2].camera_from_world * map.keyframes[4].camera_from_world.inverse();
  height.by_direction << 0, 6, 0;
  RigidTransform pose = map.keyframes[4].camera_from_world.inverse();
  pose.translation.y() += 0.1;
  map.keyframes[4].camera_from_world = pose.inverse();
  VehicleStep step = StepBetween(3, 6);
  SetStepHeight(map, {height}, step);
  EXPECT_EQ(step.height, 0);
}

TEST(RoadHeights, AStepThatShowsNoRoadHasNone) {
  const Map map = StraightMap(10);
  const std::vector<MeasuredHeight> heights = {Measured(4, 3, 0.8, 0.01)};
  VehicleStep other = StepBetween(4, 8);
  SetStepHeight(map, heights, other);
  EXPECT_EQ(other.height, 0);
  VehicleStep gap = StepBetween(3, 4);
  gap.after_gap = true;
  SetStepHeight(map, heights, gap);
  EXPECT_EQ(gap.height, 0);
  VehicleStep jump = StepBetween(3, 4);
  jump.usable = false;
  SetStepHeight(map, heights, jump);
  EXPECT_EQ(jump.height, 0);
}

}  // namespace
}  // namespace turnscale
