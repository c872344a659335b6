// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/test_seeds.h"
#include "turnscale/simulation/test_routes.h"
#include "turnscale/simulation/world.h"

namespace turnscale {
namespace {

constexpr double kCarLength = 3.6;  // from the rear axle to the front
constexpr double kCell = 2;

// The nearest place of a way, found by cells.
class Way {
 public:
  explicit Way(const VehicleMotion& motion) {
    for (double time = 0; time < motion.duration(); time += 0.02) {
      const Eigen::Vector2d place = motion.At(time).position;
      cells_[CellOf(place)].push_back(place);
    }
  }

  // Up to kCell; further away is as far.
  double DistanceTo(const Eigen::Vector2d& place) const {
    double nearest = kCell;
    const auto [x, z] = CellOf(place);
    for (int i = -1; i <= 1; ++i)
      for (int k = -1; k <= 1; ++k)
        if (const auto cell = cells_.find({x + i, z + k}); cell != cells_.end())
          for (const Eigen::Vector2d& point : cell->second) nearest = std::min(nearest, (point - place).norm());
    return nearest;
  }

 private:
  static std::pair<int, int> CellOf(const Eigen::Vector2d& place) {
    return {static_cast<int>(std::floor(place.x() / kCell)), static_cast<int>(std::floor(place.y() / kCell))};
  }

  std::map<std::pair<int, int>, std::vector<Eigen::Vector2d>> cells_;
};

// How near anything that stands, from a hand's breadth above the road up to a car's roof, comes to the rear axle's way.
double NearestObstacle(const World& world) {
  const Way way(Driven(world));
  double nearest = kCell;
  for (const Eigen::Vector3f& vertex : world.scene.fixed.vertices) {
    const Eigen::Vector2d place(vertex.x(), vertex.z());
    const double height = -vertex.y() - world.road(place);
    if (height > 0.2 && height < 1.6) nearest = std::min(nearest, way.DistanceTo(place));
  }
  return nearest;
}

// How near the middle of anything that moves comes to the middle line of the car at the same moment.
double NearestEncounter(const World& world) {
  const VehicleMotion motion = Driven(world);
  double nearest = 100;
  for (double time = 0; time < motion.duration(); time += 0.1) {
    const VehicleState state = motion.At(time);
    const Eigen::Vector2d ahead(std::sin(state.heading), std::cos(state.heading));
    for (const auto& world_from_movable : world.world_from_movable) {
      const Eigen::Vector3d at = world_from_movable(time).translation;
      if (std::abs(-at.y() - world.road({at.x(), at.z()})) > 1) continue;  // on another floor, or hidden
      const Eigen::Vector2d from_axle = Eigen::Vector2d(at.x(), at.z()) - state.position;
      const double along = std::clamp(from_axle.dot(ahead), -1.0, kCarLength);
      nearest = std::min(nearest, (from_axle - along * ahead).norm());
    }
  }
  return nearest;
}

void ExpectClear(const World& world) {
  EXPECT_GT(NearestObstacle(world), kHalfCarWidth);
  EXPECT_GT(NearestEncounter(world), kHalfCarWidth + 0.3);
}

TEST(WorldClearance, NobodyAndNothingIsInTheCarsWay) {
  for (int seed = 1; seed <= SeedsToTest(2); ++seed) {
    SCOPED_TRACE(seed);
    ExpectClear(MakeGarage(static_cast<unsigned>(seed), 75));
    ExpectClear(MakeStreet(static_cast<unsigned>(seed), 60));
  }
}

TEST(WorldClearance, PointsFarApartMakeTheSameStreet) {
  std::vector<Eigen::Vector3d> path;
  for (double at = 0; at <= 150; at += 12) path.emplace_back(0.1 * at, 0, at);
  const World world = MakeStreetAlong(1, path, std::vector<double>(path.size(), 8.0));
  EXPECT_GT(NearestObstacle(world), kHalfCarWidth);
  for (double at = 5; at < 145; at += 1) EXPECT_LT(std::abs(world.road({0.1 * at, at})), 0.2) << at;
}

TEST(WorldClearance, MoreSecondsMakeLongerDrives) {
  for (World (*make)(unsigned, double) : {MakeGarage, MakeStreet}) {
    double before = 0;
    for (const double seconds : {20.0, 60.0}) {
      const double duration = Driven(make(1, seconds)).duration();
      EXPECT_NEAR(duration, seconds, 12 + 0.1 * seconds);
      EXPECT_GT(duration, before + 15);
      before = duration;
    }
  }
}

}  // namespace
}  // namespace turnscale
