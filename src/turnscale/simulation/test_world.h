// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "turnscale/geometry/rotation.h"
#include "turnscale/rendering/pattern.h"
#include "turnscale/simulation/world.h"

namespace turnscale {

/// Where a small glowing board of MakeTestWorld stands, metres.
inline const Eigen::Vector3d kTestBoard = {3, -1.2, 16};

/// Its brightness.
constexpr float kTestGlow = 20;

/// Where the other glowing board is at a time (s): it crosses the way ahead at 4 m/s.
inline RigidTransform TestCar(double time) { return {Eigen::Quaterniond::Identity(), {4 * time - 4, 0, 22}}; }
/// Its centre in TestCar's frame.
inline const Eigen::Vector3d kTestCarBoard = {0, -2, 0};

/// A yard with a textured floor, boxes and two glowing boards that face the car: one stands, one moves. The car sets
/// off at 5 m/s from the origin along z and bends to the right; `seconds` is about the length of the drive.
inline World MakeTestWorld(double seconds) {
  World world;
  Scene& scene = world.scene;
  scene.patterns.push_back({[] { return PavementPattern({.side = 512, .seed = 1}); }, 4.0});
  scene.patterns.push_back({[] { return CloudPattern({.side = 512, .seed = 2, .contrast = 0.2F}); }, 3.0});
  constexpr int kFloor = 0;
  constexpr int kWall = 1;
  constexpr int kGlowing = 2;
  scene.materials = {{.pattern = 0}, {.pattern = 1}, {.pattern = 1, .tint = 0, .glow = kTestGlow}};
  scene.sky = 0.6F;
  scene.ambient = 0.8F;
  AddRectangle({.material = kFloor, .light_step = 4}, {-40, 0, -20}, {0, 0, 80}, {80, 0, 0}, scene.fixed);
  int count = 0;
  const auto add_box = [&](double x, double z) {
    const SurfaceStyle style{.material = kWall, .light_step = 4, .texture_offset = {0.7 * count, 1.3 * count}};
    AddBox(style, {RotationFromVector({0, 0.3 * count, 0}), {x, 0, z}}, {.size = {3, 2.0 + count % 3, 3}}, scene.fixed);
    world.floor_plan.push_back({{x - 1.5, z - 1.5}, {x - 1.5, z + 1.5}, {x + 1.5, z + 1.5}, {x + 1.5, z - 1.5}});
    ++count;
  };
  for (int i = 0; i < 7; ++i) {
    add_box(-7 - i % 2, 4.0 + 6 * i);
    add_box(9 + 4 * i, 6 - i % 3);
    add_box(6 + 5 * i, 30 + i % 3);
  }
  constexpr double kSide = 0.16;
  const auto add_board = [&](const Eigen::Vector3d& centre, Mesh& mesh) {
    AddRectangle({.material = kGlowing}, centre + Eigen::Vector3d(-kSide / 2, kSide / 2, 0), {0, -kSide, 0},
                 {kSide, 0, 0}, mesh);
  };
  add_board(kTestBoard, scene.fixed);
  scene.movable.emplace_back();
  add_board(kTestCarBoard, scene.movable.back());
  world.world_from_movable.emplace_back(TestCar);
  world.road = [](const Eigen::Vector2d&) { return 0.0; };

  RouteLeg leg;
  constexpr double kSpeed = 5;
  constexpr double kRadius = 12;
  for (double s = 0; s <= kSpeed * seconds; s += 0.5) {
    const double angle = std::max(0.0, s - 2) / kRadius;
    leg.points.emplace_back(kRadius * (1 - std::cos(angle)), std::min(s, 2.0) + kRadius * std::sin(angle));
    leg.speeds.push_back(kSpeed);
  }
  world.legs = {leg};
  return world;
}

}  // namespace turnscale
