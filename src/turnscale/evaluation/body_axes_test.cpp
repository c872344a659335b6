// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/body_axes.h"

#include <gtest/gtest.h>

#include "turnscale/evaluation/test_drive.h"

namespace turnscale {
namespace {

const RigidTransform kAnotherWorld{RotationFromVector({0.3, -2.0, 0.5}), {10, -20, 30}};

BodyAxes Compared(const Trajectory& estimate, const Trajectory& truth) {
  const PosePairs pairs = AssociateByTime(estimate, truth);
  return CompareBodyAxes(pairs, StepsAlongPath(pairs));
}

Trajectory WithAxes(Trajectory path, const Eigen::Quaterniond& other_from_body) {
  for (StampedPose& pose : path) pose.world_from_camera = WithOtherAxes(pose.world_from_camera, other_from_body);
  return path;
}

TEST(BodyAxes, AreFoundWhateverTheWorldAndTheScale) {
  const Trajectory camera = WindingDrive(200);
  Eigen::Matrix3d body_from_camera;  // x forward, y left, z up
  body_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  for (const Eigen::Quaterniond& mount :
       {Eigen::Quaterniond::Identity(), Eigen::Quaterniond(body_from_camera), RotationFromVector({0.1, 2.5, -0.7})}) {
    const Trajectory truth = Moved(WithAxes(camera, mount), kAnotherWorld);
    const BodyAxes axes = Compared(Scaled(camera, 0.05), truth);
    EXPECT_LT(RotationAngle(axes.estimate_from_truth * mount), 1e-6);
    EXPECT_NEAR(axes.turned.way, 1, 1e-9);
    EXPECT_NEAR(axes.turned.turn, 1, 1e-9);
  }
}

TEST(BodyAxes, AnErrorIsNoneOfTheAxes) {
  const Trajectory truth = WindingDrive(200);
  const BodyAxes same = Compared(truth, truth);
  EXPECT_NEAR(same.as_given.way, 1, 1e-9);
  EXPECT_NEAR(same.as_given.turn, 1, 1e-9);
  Trajectory inverse = truth;
  for (StampedPose& pose : inverse) pose.world_from_camera = pose.world_from_camera.inverse();
  EXPECT_LT(Compared(truth, inverse).turned.way, 0.8) << "the inverse poses are no other axes";
}

TEST(BodyAxes, AStraightPathShowsTheDirectionOnly) {
  Trajectory straight;
  for (int i = 0; i < 30; ++i) straight.push_back({0.1 * i, {Eigen::Quaterniond::Identity(), {0, 0, 1.0 * i}}});
  const BodyAxes axes = Compared(straight, WithAxes(straight, RotationFromVector({0, 1.5, 0})));
  EXPECT_LT(axes.as_given.way, 0.1);
  EXPECT_NEAR(axes.turned.way, 1, 1e-9);
  EXPECT_EQ(axes.turned.turn, 0);
}

}  // namespace
}  // namespace turnscale
