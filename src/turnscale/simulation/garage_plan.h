// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "turnscale/base/random.h"
#include "turnscale/simulation/vehicle.h"

namespace turnscale::garage {

// Two halls side by side, the eastern one a storey higher, a ramp between them; x east, z north, metres. In each hall
// two lanes run north, with bays on both sides, and lanes across join them at the ends.
constexpr double kBayDepth = 5;
constexpr double kBayWidth = 2.5;
constexpr double kAisle = 6.5;
constexpr int kBays = 16;
constexpr double kHallWidth = 4 * kBayDepth + 2 * kAisle;
constexpr double kHallDepth = 2 * kAisle + kBays * kBayWidth;
constexpr double kRampWidth = 6;
constexpr double kUpperX = kHallWidth + kRampWidth;
constexpr double kStorey = 3;
/// Western edges of the rows of bays, from the hall's western wall.
constexpr std::array<double, 4> kBayRows = {0, kBayDepth + kAisle, 2 * kBayDepth + kAisle, 3 * kBayDepth + 2 * kAisle};
/// Middles of the lanes.
constexpr std::array<double, 2> kAisles = {kBayDepth + kAisle / 2, 3 * kBayDepth + 1.5 * kAisle};
/// Pillars stand a little back from the lanes.
constexpr std::array<double, 4> kPillarRows = {4.4, 12.1, 20.9, 28.6};

/// Southern edge of a bay.
constexpr double BayEdge(int bay) { return kAisle + bay * kBayWidth; }

/// Height of the road at (x, z).
double RoadUp(const Eigen::Vector2d& place);

/// One parking space.
struct Bay {
  double x0 = 0;  ///< its hall's western wall
  int row = 0;
  int bay = 0;

  bool operator==(const Bay&) const = default;
};

/// Where the drive starts and how it goes.
struct Plan {
  Bay start;
  std::vector<RouteLeg> legs;
};

/// Backs out of a space, goes round, over the ramp and round again, to either side: laps until about so many seconds
/// are over.
Plan MakePlan(Random& random, double seconds);

}  // namespace turnscale::garage
