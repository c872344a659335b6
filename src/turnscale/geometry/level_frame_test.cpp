// SPDX-License-Identifier: MIT
#include "turnscale/geometry/level_frame.h"

#include <cmath>

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

TEST(LevelFrame, FromAboveTheWorldsXAxisGoesRight) {
  const Trajectory drive = {{0, {}}, {0.1, {Eigen::Quaterniond::Identity(), {0, 0, 1}}}};
  const auto axes_in = [&](const Eigen::Quaterniond& other_from_world) {
    Trajectory moved = drive;
    for (StampedPose& pose : moved)
      pose.world_from_camera = RigidTransform{other_from_world, Eigen::Vector3d::Zero()} * pose.world_from_camera;
    return TopViewAxes(moved, Eigen::Quaterniond::Identity());
  };
  Eigen::Matrix<double, 2, 3> x_and_z;
  x_and_z << 1, 0, 0, 0, 0, 1;
  EXPECT_LT((axes_in(Eigen::Quaterniond::Identity()) - x_and_z).norm(), 1e-12) << "y down";
  // x right, y ahead, z up.
  const Eigen::Quaterniond z_up = RotationFromVector({-M_PI / 2, 0, 0});
  Eigen::Matrix<double, 2, 3> x_and_y;
  x_and_y << 1, 0, 0, 0, 1, 0;
  EXPECT_LT((axes_in(z_up) - x_and_y).norm(), 1e-12);
}

}  // namespace
}  // namespace turnscale
