// SPDX-License-Identifier: MIT
#include "turnscale/mapping/pose_estimation.h"

#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

struct Scene {
  RigidTransform camera_from_world{RotationFromVector({0.1, -0.4, 0.05}), {0.5, -0.2, 1.0}};
  std::vector<PointSighting> sightings;
};

Scene MakeScene(int points, double noise, unsigned seed, double unit = 1.0, double away = 0.0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(100, 1100);
  std::uniform_real_distribution<double> y(20, 340);
  std::uniform_real_distribution<double> depth(4, 40);
  std::normal_distribution<double> normal;
  Scene scene;
  scene.camera_from_world.translation *= unit;
  scene.camera_from_world.translation += away * Eigen::Vector3d(0.6, 0, 0.8);
  for (int i = 0; i < points; ++i) {
    const double row = y(random);
    const Eigen::Vector2d pixel(x(random), row);
    const Eigen::Vector3d in_camera = unit * depth(random) * kTestPinhole.Ray(pixel);
    scene.sightings.push_back(
        {scene.camera_from_world.inverse() * in_camera, pixel + noise * DrawVector<2>([&] { return normal(random); })});
  }
  return scene;
}

RigidTransform Disturbed(const RigidTransform& pose, double unit = 1.0) {
  return RigidTransform{RotationFromVector({0.02, 0.03, -0.01}), unit * Eigen::Vector3d(0.3, -0.1, 0.4)} * pose;
}

TEST(PoseEstimation, ExactWithoutNoise) {
  const Scene scene = MakeScene(50, 0, 1);
  const PoseEstimate estimate = EstimatePose({}, kTestPinhole, scene.sightings, Disturbed(scene.camera_from_world));
  const RigidTransform off = estimate.camera_from_world * scene.camera_from_world.inverse();
  EXPECT_LT(RotationAngle(off.rotation), 1e-9);
  EXPECT_LT(off.translation.norm(), 1e-8);
  EXPECT_EQ(estimate.inliers, 50);
}

TEST(PoseEstimation, OutliersLoseTheirSay) {
  Scene scene = MakeScene(200, 0.3, 2);
  for (int i = 0; i < 60; ++i) scene.sightings[i].pixel += Eigen::Vector2d(8 + i, -5);
  const PoseEstimate estimate = EstimatePose({}, kTestPinhole, scene.sightings, Disturbed(scene.camera_from_world));
  const RigidTransform off = estimate.camera_from_world * scene.camera_from_world.inverse();
  EXPECT_LT(RotationAngle(off.rotation) * kDegreesPerRadian, 0.02);
  EXPECT_LT(off.translation.norm(), 0.003);
  for (int i = 0; i < 60; ++i) EXPECT_EQ(estimate.inlier[i], 0) << i;
  EXPECT_EQ(estimate.inliers, 140);
}

// As those of a vehicle ahead, whose landmarks stay in sight.
TEST(PoseEstimation, ManyPointsInOnePlaceDoNotDominate) {
  Scene scene = MakeScene(80, 0.3, 6);
  const RigidTransform moved = Disturbed(scene.camera_from_world);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(0, 150);
  for (int i = 0; i < 160; ++i) {
    const Eigen::Vector2d pixel(500 + within(random), 100 + within(random));
    scene.sightings.push_back({moved.inverse() * (12 * kTestPinhole.Ray(pixel)), pixel});
  }
  const auto angle_off = [&](double max_cell_weight) {
    PoseEstimationOptions options;
    options.max_cell_weight = max_cell_weight;
    const PoseEstimate estimate = EstimatePose(options, kTestPinhole, scene.sightings, scene.camera_from_world);
    return RotationAngle((estimate.camera_from_world * scene.camera_from_world.inverse()).rotation) * kDegreesPerRadian;
  };
  EXPECT_LT(angle_off(PoseEstimationOptions().max_cell_weight), 0.1);
  EXPECT_GT(angle_off(1000), 1) << "otherwise they do";
  const PoseEstimate estimate = EstimatePose({}, kTestPinhole, scene.sightings, scene.camera_from_world);
  EXPECT_LT(estimate.inliers, 120);
  EXPECT_GT(estimate.inlier_share, 0.7);
}

TEST(PoseEstimation, DoesNotDependOnTheUnitOfLength) {
  const Scene one = MakeScene(100, 0.5, 3);
  const PoseEstimate reference = EstimatePose({}, kTestPinhole, one.sightings, Disturbed(one.camera_from_world));
  for (const double unit : {0.1, 10.0}) {
    const Scene scene = MakeScene(100, 0.5, 3, unit);
    const PoseEstimate estimate =
        EstimatePose({}, kTestPinhole, scene.sightings, Disturbed(scene.camera_from_world, unit));
    EXPECT_LT((estimate.camera_from_world.translation / unit - reference.camera_from_world.translation).norm(), 1e-8);
    EXPECT_EQ(estimate.inliers, reference.inliers);
  }
}

TEST(PoseEstimation, DoesNotDependOnTheDistanceFromTheOrigin) {
  Scene scene = MakeScene(60, 0.3, 4, 1.0, /*away=*/1e5);
  for (int i = 0; i < 9; ++i) scene.sightings[i].pixel += Eigen::Vector2d(8 + i, -5);
  const RigidTransform turned =
      RigidTransform{RotationFromVector({0, 0.05, 0}), Eigen::Vector3d::Zero()} * scene.camera_from_world;
  const PoseEstimate estimate = EstimatePose({}, kTestPinhole, scene.sightings, turned);
  const RigidTransform off = estimate.camera_from_world * scene.camera_from_world.inverse();
  EXPECT_LT(InDegrees(RotationAngle(off.rotation)), 0.05);
  EXPECT_LT(off.translation.norm(), 0.02);
  EXPECT_EQ(estimate.inliers, 51);
}

TEST(PoseEstimation, TooFewSightingsGiveNoInliersOutOfNothing) {
  const PoseEstimate estimate = EstimatePose({}, kTestPinhole, {}, RigidTransform{});
  EXPECT_EQ(estimate.inliers, 0);
  EXPECT_TRUE(estimate.camera_from_world.translation.allFinite());
}

TEST(PoseEstimation, OptionsNameTheFieldThatMakesNoSense) {
  using Options = PoseEstimationOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.inlier_threshold = 0; }), "inlier_threshold");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.huber_threshold = 0; }), "huber_threshold");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_iterations = 0; }), "max_iterations");
}

}  // namespace
}  // namespace turnscale
