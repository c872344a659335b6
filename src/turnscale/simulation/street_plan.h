// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/base/random.h"
#include "turnscale/simulation/road_map.h"
#include "turnscale/simulation/vehicle.h"

namespace turnscale::street {

// Traffic keeps right. The middle of the road lies this far left of the way that is driven, metres.
constexpr double kMiddle = 1.4;
constexpr double kRoadHalfWidth = 5.6;
constexpr double kPavementWidth = 2.2;

/// A drive through streets: the way, and the middles of all roads, those that are only crossed included.
struct Plan {
  std::vector<RoadPoint> driven;
  std::vector<std::vector<RoadPoint>> roads;
  std::vector<RouteLeg> legs;
};

/// Streets on a grid with blocks of changing length: straights, corners to both sides, a halt at a crossing.
Plan MakePlan(Random& random, double seconds);

/// Streets under a recorded way (x, up, z; metres), which is driven at its speeds (m/s).
Plan PlanAlong(const std::vector<Eigen::Vector3d>& path, const std::vector<double>& speeds);

/// The points of a way moved sideways, to the right for positive distances.
std::vector<RoadPoint> Beside(const std::vector<RoadPoint>& way, double right);

/// Unit vector along a way at one of its points.
Eigen::Vector2d Along(const std::vector<RoadPoint>& way, int point);

}  // namespace turnscale::street
