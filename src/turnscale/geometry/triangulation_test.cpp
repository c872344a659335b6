// SPDX-License-Identifier: MIT
#include "turnscale/geometry/triangulation.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// A camera with a random pose and the ray on which it sees the point, in front of it.
CameraRay RandomRayTo(const Eigen::Vector3d& x, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return DrawVector<3>([&] { return normal(random); }); };
  const RigidTransform pose{RotationFromVector(vector()), vector()};
  return {pose, pose * x};
}

TEST(Triangulation, FindsThePointThatAllRaysMeet) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d x = Eigen::Vector3d(0, 0, 10) + DrawVector<3>([&] { return normal(random); });
    std::vector<CameraRay> rays;
    for (int i = 0; i < 2 + trial % 3; ++i) rays.push_back(RandomRayTo(x, random));
    const std::optional<Eigen::Vector3d> found = Triangulate(rays);
    ASSERT_TRUE(found.has_value());
    EXPECT_LT((*found - x).norm(), 1e-9);
  }
}

TEST(Triangulation, KeepsItsDigitsFarFromTheOrigin) {
  const Eigen::Vector3d far(1e5, 0, 1e5);
  const Eigen::Vector3d x = far + Eigen::Vector3d(0.3, 0.2, 8);
  const RigidTransform a{Eigen::Quaterniond::Identity(), -far};
  const RigidTransform b{Eigen::Quaterniond::Identity(), -far - Eigen::Vector3d(0.5, 0, 0)};
  const std::vector<CameraRay> rays = {{a, a * x}, {b, b * x}};
  const std::optional<Eigen::Vector3d> found = Triangulate(rays);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((*found - x).norm(), 1e-8);
}

TEST(Triangulation, RefusesParallelRaysAndPointsBehind) {
  const RigidTransform a;
  const RigidTransform b{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  const std::vector<CameraRay> parallel = {{a, {0, 0, 1}}, {b, {0, 0, 1}}};
  EXPECT_FALSE(Triangulate(parallel).has_value());
  // Rays that part meet behind the cameras.
  const std::vector<CameraRay> parting = {{a, {-0.1, 0, 1}}, {b, {0.1, 0, 1}}};
  EXPECT_FALSE(Triangulate(parting).has_value());
  EXPECT_FALSE(Triangulate(std::vector<CameraRay>{{a, {0, 0, 1}}}).has_value());
}

TEST(Triangulation, ParallaxIsTheAngleAtThePoint) {
  const RigidTransform a;
  const RigidTransform b{Eigen::Quaterniond::Identity(), {-2, 0, 0}};
  EXPECT_NEAR(ParallaxAngle(a, b, {1, 0, 1}), 90 / kDegreesPerRadian, 1e-12);
}

}  // namespace
}  // namespace turnscale
