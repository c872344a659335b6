// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/rendering/scene.h"
#include "turnscale/simulation/vehicle.h"

namespace turnscale {

/// A place to drive in, and the way through it.
struct World {
  Scene scene;
  /// World from each of Scene::movable, by the time of the drive (s): other cars, people.
  std::vector<std::function<RigidTransform(double)>> world_from_movable;
  std::vector<RouteLeg> legs;
  RoadHeight road;
  /// Outlines of what stands there, (x, z) in metres, closed: for a picture of the path over the floor plan.
  std::vector<std::vector<Eigen::Vector2d>> floor_plan;
};

/// A parking garage: two floors with pillars, parked cars and polished floors, a ramp between them. The car backs out
/// of its space, drives round one floor, over the ramp and round the other one, until about `seconds` are over.
World MakeGarage(unsigned seed, double seconds);

/// Streets between houses, trees, parked and moving cars, crossings and long straights, for about so many seconds.
World MakeStreet(unsigned seed, double seconds);

/// Streets around a recorded path: `path` is the rear axle's way (x, up, z; metres) with its speeds (m/s).
World MakeStreetAlong(unsigned seed, const std::vector<Eigen::Vector3d>& path, const std::vector<double>& speeds);

}  // namespace turnscale
