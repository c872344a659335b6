// SPDX-License-Identifier: MIT
#include "turnscale/rendering/light.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "turnscale/rendering/mesh.h"
#include "turnscale/rendering/test_scene.h"

namespace turnscale {
namespace {

const Eigen::Vector3f kUp(0, -1, 0);

Scene Baked(Scene scene, int threads = 2) {
  const RayScene rays(scene);
  BakeLight(rays, threads, scene);
  return scene;
}

// Light of the vertex of the fixed mesh that is nearest to a place, among those that face as asked.
float LightAt(const Scene& scene, const Eigen::Vector3f& place, const Eigen::Vector3f& normal) {
  float nearest = 1e9F;
  float light = -1;
  for (const Triangle& triangle : scene.fixed.triangles) {
    if (NormalOf(scene.fixed, triangle).dot(normal) < 0.9F) continue;
    for (const int vertex : triangle.vertices) {
      const float distance = (scene.fixed.vertices[vertex] - place).norm();
      if (distance >= nearest) continue;
      nearest = distance;
      light = scene.fixed.light[vertex];
    }
  }
  return light;
}

TEST(Lamp, StrengthIsWhatAWhiteFloorOneMetreBelowReturns) {
  for (const Eigen::Vector2f& size :
       {Eigen::Vector2f(1.2F, 0.2F), Eigen::Vector2f(0.1F, 2), Eigen::Vector2f(0.3F, 0.3F)}) {
    Lamp lamp{{1, -3, 2}, size.x(), size.y(), 5};
    const LampLight light(lamp);
    const auto at = [&](const Eigen::Vector3f& place, const Eigen::Vector3f& normal) {
      float sum = 0;
      for (const Eigen::Vector3f& part : light.parts()) sum += light.From(part, place, normal);
      return sum;
    };
    const float below = at({1, -2, 2}, kUp);
    EXPECT_NEAR(below, 5, 0.05);
    // Far from it, a quarter at twice the distance, but for the fading towards its reach; none above it or from behind.
    EXPECT_NEAR(at({1, 1, 2}, kUp) / below, 1.0 / 16, 0.02);
    EXPECT_EQ(at({1, -3.5F, 2}, -kUp), 0);
    EXPECT_EQ(at({1, -2, 2}, -kUp), 0);
    EXPECT_EQ(at({1, 20, 2}, kUp), 0);
  }
}

TEST(LightBaking, OpenGroundGetsAllAmbientLightAndCornersLess) {
  Scene scene = EmptyScene();
  scene.ambient = 0.5F;
  AddRectangle({kWhite, 0.5, {0, 0}}, {-20, 0, -20}, {40, 0, 0}, {0, 0, 40}, scene.fixed);
  AddRectangle({kWhite, 0.5, {0, 0}}, {0, -10, -20}, {0, 0, 40}, {0, 10, 0}, scene.fixed);
  scene = Baked(std::move(scene));
  EXPECT_NEAR(LightAt(scene, {15, 0, 0}, kUp), 0.5, 1e-6);
  // At the foot of a wall half of the sky is near and gives its bounce only.
  const float corner = LightAt(scene, {0, 0, 0}, kUp);
  EXPECT_GT(corner, 0.2F);
  EXPECT_LT(corner, 0.4F);
  EXPECT_GT(LightAt(scene, {-2, 0, 0}, kUp), corner);
}

TEST(LightBaking, LampsThrowShadows) {
  Scene scene = EmptyScene();
  scene.ambient = 0;
  scene.lamps.push_back({{0, -3, 0}, 0.4F, 0.4F, 9});
  AddRectangle({kWhite, 0.25, {0, 0}}, {-8, 0, -8}, {16, 0, 0}, {0, 0, 16}, scene.fixed);
  AddRectangle({kWhite, 0.25, {0, 0}}, {1, -1, -2}, {1, 0, 0}, {0, 0, 4}, scene.fixed);
  scene = Baked(std::move(scene));
  EXPECT_NEAR(LightAt(scene, {0, 0, 0}, kUp), 1, 0.12);
  // The plate from x = 1 to 2, one metre up, shades from 1.5 to 3; its own upper side is lit.
  EXPECT_EQ(LightAt(scene, {2.25F, 0, 0}, kUp), 0);
  EXPECT_GT(LightAt(scene, {4, 0, 0}, kUp), 0.05F);
  EXPECT_GT(LightAt(scene, {1.5F, -1, 0}, kUp), 0.5F);
}

TEST(LightBaking, WhatIsBuriedDoesNotDarkenItsNeighbours) {
  Scene scene = EmptyScene();
  AddRectangle({kWhite, 1, {0, 0}}, {-5, 0, -5}, {10, 0, 0}, {0, 0, 10}, scene.fixed);
  AddBox({kWhite, 0.2, {0, 0}}, {}, {{0.4, 3, 0.4}}, scene.fixed);
  scene = Baked(std::move(scene));
  EXPECT_GT(LightAt(scene, {0, 0, 0}, kUp), 0.8F);
}

TEST(LightBaking, DoesNotDependOnThreads) {
  Scene scene = EmptyScene();
  scene.lamps.push_back({{0, -3, 0}, 0.4F, 0.4F, 9});
  AddRectangle({kWhite, 0.3, {0, 0}}, {-8, 0, -8}, {16, 0, 0}, {0, 0, 16}, scene.fixed);
  for (int i = 0; i < 8; ++i) {
    RigidTransform pose;
    pose.translation = {2.0 * i - 8, 0, 0.5 * i};
    AddBox({kWhite, 0.3, {0, 0}}, pose, {}, scene.fixed);
  }
  AddBox({kWhite, 0.3, {0, 0}}, {}, {}, scene.movable.emplace_back());
  const Scene one = Baked(scene, 1);
  const Scene three = Baked(scene, 3);
  EXPECT_EQ(one.fixed.light, three.fixed.light);
  EXPECT_EQ(one.movable[0].light, three.movable[0].light);
  EXPECT_EQ(one.movable[0].light.size(), one.movable[0].vertices.size());
}

TEST(LightBaking, KeepsLightThatIsThere) {
  Scene scene = EmptyScene();
  AddRectangle({kWhite, 1, {0, 0}}, {-1, 0, -1}, {2, 0, 0}, {0, 0, 2}, scene.fixed);
  scene.fixed.light.assign(scene.fixed.vertices.size(), 0.123F);
  EXPECT_EQ(Baked(scene).fixed.light, scene.fixed.light);
}

TEST(Sky, IsBrighterAtTheHorizonAndDarkIndoors) {
  const Sky sky(0.8F);
  const auto ring = [&](float up) {
    float sum = 0;
    for (int i = 0; i < 64; ++i) {
      const float angle = static_cast<float>(i) * 0.0982F;
      const float across = std::sqrt(1 - up * up);
      sum += sky.At({across * std::cos(angle), -up, across * std::sin(angle)}, 1e-3F) / 64;
    }
    return sum;
  };
  EXPECT_NEAR(ring(0.95F), 0.8, 0.15);
  EXPECT_GT(ring(0.05F), 1.3F * ring(0.95F));
  EXPECT_EQ(Sky(0).At({0, -1, 0}, 1e-3F), 0);
}

}  // namespace
}  // namespace turnscale
