// SPDX-License-Identifier: MIT
#include "turnscale/odometry/metric_path.h"

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Keyframes 1 and 3 units ahead; their places in metres, at 2 and 5 metres a unit.
Map KeyframesAhead() {
  Map map;
  const Eigen::Quaterniond turned = RotationFromVector({0.1, 0.4, -0.2});
  map.keyframes.push_back({0, 0, RigidTransform{turned, {0, 0, 1}}.inverse(), {}, false});
  map.keyframes.push_back({5, 0.5, RigidTransform{turned, {0, 0, 3}}.inverse(), {}, false});
  return map;
}

const MetricPath kPath{{{0, 0, 2}, {0, 0, 9}}, {2, 5}};

TEST(MetricPath, AKeyframeIsWhereThePathHasIt) {
  const Map map = KeyframesAhead();
  for (const int k : {0, 1}) {
    const RigidTransform pose = map.keyframes[k].camera_from_world.inverse();
    const RigidTransform metric = kPath.InMetres(map, k, pose);
    EXPECT_LT((metric.translation - kPath.centres[k]).norm(), 1e-12);
    EXPECT_LT(metric.rotation.angularDistance(pose.rotation), 1e-12);
  }
}

TEST(MetricPath, WhatIsNearAKeyframeIsAsFarInItsMetres) {
  const Map map = KeyframesAhead();
  const Eigen::Vector3d off(0.3, -0.1, 0.2);
  EXPECT_LT((kPath.InMetres(map, 0, Eigen::Vector3d(0, 0, 1) + off) - (kPath.centres[0] + 2 * off)).norm(), 1e-12);
  EXPECT_LT((kPath.InMetres(map, 1, Eigen::Vector3d(0, 0, 3) + off) - (kPath.centres[1] + 5 * off)).norm(), 1e-12);
}

}  // namespace
}  // namespace turnscale
