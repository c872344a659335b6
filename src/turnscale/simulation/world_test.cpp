// SPDX-License-Identifier: MIT
#include "turnscale/simulation/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "turnscale/simulation/test_routes.h"

namespace turnscale {
namespace {

double ToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double share = std::clamp((point - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - a - share * along).norm();
}

double ToOutline(const Eigen::Vector2d& point, const std::vector<Eigen::Vector2d>& outline) {
  double nearest = 1e9;
  for (size_t i = 0; i < outline.size(); ++i)
    nearest = std::min(nearest, ToSegment(point, outline[i], outline[(i + 1) % outline.size()]));
  return nearest;
}

// From the car's way, but for its first leg, to whatever stands.
double Clearance(const World& world, size_t first_leg) {
  double nearest = 1e9;
  for (size_t leg = first_leg; leg < world.legs.size(); ++leg)
    for (size_t i = 0; i < world.legs[leg].points.size(); i += 2)
      for (const std::vector<Eigen::Vector2d>& outline : world.floor_plan) {
        const bool is_hall = (outline[2] - outline[0]).norm() > 40;
        if (!is_hall) nearest = std::min(nearest, ToOutline(world.legs[leg].points[i], outline));
      }
  return nearest;
}

// How far the car turns to each side in all, rad.
std::pair<double, double> TurnedLeftAndRight(const VehicleMotion& motion) {
  std::pair<double, double> turned(0, 0);
  constexpr double kStep = 0.1;
  for (double time = kStep; time < motion.duration(); time += kStep) {
    const double turn = motion.At(time).heading - motion.At(time - kStep).heading;
    (turn < 0 ? turned.first : turned.second) += std::abs(turn);
  }
  return turned;
}

class Worlds : public testing::TestWithParam<unsigned> {};

// One test of all that is asked of a world: making it is what takes time.
TEST_P(Worlds, GarageLeavesTheWayClearTurnsToBothSidesAndChangesFloor) {
  const World world = MakeGarage(GetParam(), 60);
  EXPECT_GT(Clearance(world, 1), kHalfCarWidth);
  const VehicleMotion motion = Driven(world);
  EXPECT_NEAR(motion.duration(), 60, 20);
  const auto [left, right] = TurnedLeftAndRight(motion);
  EXPECT_GT(left, std::numbers::pi / 2);
  EXPECT_GT(right, std::numbers::pi / 2);
  double low = 1e9;
  double high = -1e9;
  for (double time = 0; time < motion.duration(); time += 0.5) {
    const double up = world.road(motion.At(time).position);
    low = std::min(low, up);
    high = std::max(high, up);
  }
  EXPECT_NEAR(low, 0, 1e-9);
  EXPECT_NEAR(high, 3, 1e-9);
  EXPECT_TRUE(world.legs.front().reverse);
}

TEST_P(Worlds, StreetLeavesTheWayClearAndHasALongStraight) {
  const World world = MakeStreet(GetParam(), 120);
  EXPECT_GT(Clearance(world, 0), 4);
  const VehicleMotion motion = Driven(world);
  EXPECT_NEAR(motion.duration(), 120, 35);
  double straight = 0;
  double longest = 0;
  for (double time = 0.1; time < motion.duration(); time += 0.1) {
    const VehicleState state = motion.At(time);
    straight = std::abs(state.yaw_rate) < 0.01 ? straight + 0.1 * state.speed : 0;
    longest = std::max(longest, straight);
  }
  EXPECT_GT(longest, 180);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Worlds, testing::Values(1U, 2U, 3U));

TEST(World, SameSeedSameWorld) {
  const World first = MakeGarage(3, 30);
  const World second = MakeGarage(3, 30);
  const World other = MakeGarage(4, 30);
  EXPECT_EQ(first.scene.fixed.vertices, second.scene.fixed.vertices);
  EXPECT_NE(first.scene.fixed.vertices.size(), other.scene.fixed.vertices.size());
  EXPECT_EQ(first.legs.back().points, second.legs.back().points);
}

TEST(World, StreetFollowsAPath) {
  std::vector<Eigen::Vector3d> path;
  std::vector<double> speeds;
  for (double at = 0; at < 150; at += 0.8) {
    path.emplace_back(20 * std::sin(at / 40), 0.05 * at, at);
    speeds.push_back(8);
  }
  const World world = MakeStreetAlong(1, path, speeds);
  EXPECT_GT(Clearance(world, 0), 4);
  for (size_t i = 10; i + 10 < path.size(); i += 10) {
    const double slope =
        (world.road({path[i + 5].x(), path[i + 5].z()}) - world.road({path[i - 5].x(), path[i - 5].z()})) /
        (path[i + 5].z() - path[i - 5].z());
    EXPECT_NEAR(slope, 0.05, 0.01) << "climbs as the path does, " << i;
  }
}

}  // namespace
}  // namespace turnscale
