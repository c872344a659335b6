// SPDX-License-Identifier: MIT
#include "turnscale/geometry/level_frame.h"

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

TEST(LevelFrame, TakesOutTheCamerasTiltAndTheWorlds) {
  const Eigen::Quaterniond vehicle_from_camera = RotationFromYawPitchRoll({0.2, -0.3, 0.1});
  const Eigen::Quaterniond world_from_first = RotationFromVector({0.4, 1.1, -0.7});
  Trajectory trajectory;
  for (int i = 0; i < 10; ++i) {
    // A turn to the right on level ground.
    const Eigen::Quaterniond vehicle = RotationFromVector({0, 0.2 * i, 0});
    trajectory.push_back({0.1 * i, {world_from_first * vehicle * vehicle_from_camera, Eigen::Vector3d::Zero()}});
  }
  const Eigen::Quaterniond level = LevelFromWorld(trajectory, vehicle_from_camera);
  const auto in_level = [&](const Eigen::Vector3d& in_first_vehicle) {
    return level * (world_from_first * in_first_vehicle);
  };
  EXPECT_LT((in_level({0, 0, 1}) - Eigen::Vector3d::UnitY()).norm(), 1e-9) << "ahead";
  EXPECT_LT((in_level({1, 0, 0}) - Eigen::Vector3d::UnitX()).norm(), 1e-9) << "right";
  EXPECT_LT((in_level({0, -1, 0}) - Eigen::Vector3d::UnitZ()).norm(), 1e-9) << "up";
}

}  // namespace
}  // namespace turnscale
