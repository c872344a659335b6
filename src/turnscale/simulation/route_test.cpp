// SPDX-License-Identifier: MIT
#include "turnscale/simulation/route.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/simulation/test_routes.h"

namespace turnscale {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// Turning angle per distance at each inner point.
std::vector<double> Curvatures(const Points& points) {
  std::vector<double> curvatures;
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Eigen::Vector2d a = points[i] - points[i - 1];
    const Eigen::Vector2d b = points[i + 1] - points[i];
    const double angle = std::atan2(a.y() * b.x() - a.x() * b.y(), a.dot(b));
    curvatures.push_back(2 * angle / (a.norm() + b.norm()));
  }
  return curvatures;
}

TEST(RoundCorners, KeepsEndsStepAndRadius) {
  const Points path = RoundCorners({{0, 0}, {0, 30}, {30, 30}, {30, 60}}, 6, 0.5);
  EXPECT_EQ(path.front(), Eigen::Vector2d(0, 0));
  EXPECT_EQ(path.back(), Eigen::Vector2d(30, 60));
  for (std::size_t i = 1; i < path.size(); ++i) {
    EXPECT_LE((path[i] - path[i - 1]).norm(), 0.5 + 1e-9);
    EXPECT_GE((path[i] - path[i - 1]).norm(), 0.2);
  }
  const std::vector<double> curvatures = Curvatures(path);
  EXPECT_NEAR(*std::max_element(curvatures.begin(), curvatures.end()), 1.0 / 6, 1e-3) << "to the right";
  EXPECT_NEAR(*std::min_element(curvatures.begin(), curvatures.end()), -1.0 / 6, 1e-3) << "to the left";
}

TEST(RoundCorners, CurvatureGrowsEvenly) {
  const std::vector<double> curvatures = Curvatures(RoundCorners({{0, 0}, {0, 40}, {25, 60}}, 8, 0.25));
  double greatest = 0;
  for (std::size_t i = 1; i < curvatures.size(); ++i)
    greatest = std::max(greatest, std::abs(curvatures[i] - curvatures[i - 1]));
  EXPECT_LT(greatest, 1.2 * 0.25 / (8 * 4)) << "over half a radius";
}

TEST(RoundCorners, ShortPiecesMakeTighterCorners) {
  const auto tightest = [](const Points& path) {
    const std::vector<double> curvatures = Curvatures(path);
    return *std::max_element(curvatures.begin(), curvatures.end());
  };
  EXPECT_NEAR(tightest(RoundCorners({{0, 0}, {0, 20}, {12.5, 20}, {12.5, 0}}, 6, 0.1)), 1.0 / 6, 1e-3)
      << "there is room for the radius, not for the whole transitions";
  EXPECT_NEAR(tightest(RoundCorners({{0, 0}, {0, 20}, {8, 20}, {8, 0}}, 6, 0.1)), 1.0 / 4, 4e-3);
}

TEST(RoundCorners, GoesStraightThroughCornersThatAreNone) {
  const Points path = RoundCorners({{0, 0}, {0, 10}, {0, 20}}, 6, 1);
  ASSERT_EQ(path.size(), 21u);
  for (std::size_t i = 0; i < path.size(); ++i)
    EXPECT_NEAR((path[i] - Eigen::Vector2d(0, static_cast<double>(i))).norm(), 0, 1e-12);
}

TEST(RoundCorners, RefusesWhatHasNoCorners) {
  EXPECT_THROW(RoundCorners({{0, 0}}, 6, 0.5), InputError);
  EXPECT_THROW(RoundCorners({{0, 0}, {0, 0}}, 6, 0.5), InputError);
  EXPECT_THROW(RoundCorners({{0, 0}, {0, 9}, {0, 1}}, 6, 0.5), InputError);
  EXPECT_THROW(RoundCorners({{0, 0}, {0, 9}}, 0, 0.5), InputError);
  EXPECT_THROW(RoundCorners({{0, 0}, {0, 9}}, 6, 0), InputError);
}

TEST(RouteLeg, CheckNamesTheField) {
  const auto refused = [](auto change) {
    return RefusedField<RouteLeg>([&](RouteLeg& leg) {
      leg.points = {{0, 0}, {0, 5}};
      change(leg);
    });
  };
  EXPECT_EQ(refused([](RouteLeg&) {}), "");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.points.pop_back(); }), "leg.points");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.points[1] = leg.points[0]; }), "leg.points");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.points[1].x() = std::nan(""); }), "leg.points");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.speed = 0; }), "leg.speed");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.wait = -1; }), "leg.wait");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.speeds = {1}; }), "leg.speeds");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.speeds = {1, -1}; }), "leg.speeds");
}

// A camera that looks down and to the right.
const RigidTransform kMount{RotationFromYawPitchRoll({0.1, -0.2, 0.03}), {0.3, -1.1, 1.1}};

// What the recording's world is, must not matter.
const RigidTransform kFarAway{RotationFromYawPitchRoll({2, 0, 0}), {500000, 30, 4500000}};

/// Poses at 10 Hz of a camera on a car; `noise` (metres) jitters them in all directions.
Trajectory Record(const VehicleMotion& motion, double noise) {
  Trajectory trajectory;
  for (const VehicleState& state : Moments(motion, 0.1)) {
    RigidTransform pose = kFarAway * state.world_from_vehicle * kMount;
    const double i = static_cast<double>(trajectory.size());
    pose.translation += noise * M_SQRT2 * Eigen::Vector3d(std::sin(i * i), std::sin(2 * i * i), std::sin(3 * i * i));
    trajectory.push_back({state.time, pose});
  }
  return trajectory;
}

std::vector<RouteLeg> WayWithAStop() {
  RouteLeg first;
  first.points = RoundCorners({{0, 0}, {0, 30}, {30, 30}}, 7, 0.5);
  first.wait = 5;
  RouteLeg second;
  second.points = {{30, 30}, {60, 30}};
  return {first, second};
}

// Level where the way begins.
double Hill(const Eigen::Vector2d& place) { return 2 - 2 * std::cos(0.06 * place.x()); }

TEST(RearAxlePath, IsTheRearAxlesWay) {
  const VehicleMotion motion = Drive(StiffVehicle(), WayWithAStop(), Hill, 0.3, 1);
  for (const double noise : {0.0, 0.02}) {
    const RecordedPath path = RearAxlePath(Record(motion, noise), kMount);
    ASSERT_EQ(path.points.size(), path.speeds.size());
    std::vector<Eigen::Vector2d> way;
    for (const VehicleState& state : Moments(motion, 0.05)) way.push_back(state.position);
    way.erase(std::unique(way.begin(), way.end()), way.end());
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const Eigen::Vector2d place(path.points[i].x(), path.points[i].z());
      EXPECT_LT(DistanceFromPath(place, way), 0.01 + 2 * noise);
      EXPECT_NEAR(path.points[i].y(), Hill(place), 0.015 + noise);
      if (i == 0) continue;
      EXPECT_GE((path.points[i] - path.points[i - 1]).norm(), 0.3);
      EXPECT_LT((path.points[i] - path.points[i - 1]).norm(), 1.0);
    }
    EXPECT_LT((path.points.back() - Eigen::Vector3d(60, 0, 30)).cwiseProduct(Eigen::Vector3d(1, 0, 1)).norm(), 0.4);
  }
}

TEST(RearAxlePath, HasTheSpeedsAndNoDuplicatesWhereTheCarStands) {
  const VehicleMotion motion = Drive(StiffVehicle(), WayWithAStop(), FlatRoad, 0.3, 1);
  for (const double noise : {0.0, 0.02}) {
    const RecordedPath path = RearAxlePath(Record(motion, noise), kMount);
    int at_the_stop = 0;
    double slowest = 100;
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const double from_stop = std::abs(path.points[i].x() - 30);
      if (from_stop < 0.29 && path.points[i].z() > 29) ++at_the_stop;
      if (from_stop < 1) slowest = std::min(slowest, path.speeds[i]);
      if (path.points[i].x() > 42 && path.points[i].x() < 50) {
        EXPECT_NEAR(path.speeds[i], 5, 0.03 + 5 * noise);
      }
    }
    EXPECT_LE(at_the_stop, 2);
    EXPECT_LT(slowest, 0.01 + 3 * noise);
  }
}

TEST(RearAxlePath, CanBeDrivenAgain) {
  const VehicleMotion motion = Drive(StiffVehicle(), WayWithAStop(), FlatRoad, 0.3, 1);
  const RecordedPath path = RearAxlePath(Record(motion, 0.01), kMount);
  RouteLeg leg;
  for (const Eigen::Vector3d& point : path.points) leg.points.emplace_back(point.x(), point.z());
  leg.speeds = path.speeds;
  const VehicleMotion again = DriveFlat({}, {leg});
  EXPECT_NEAR(again.duration(), motion.duration() - 5, 4) << "without the five seconds at the stop";
  std::vector<Eigen::Vector2d> way;
  for (const VehicleState& state : Moments(motion, 0.05)) way.push_back(state.position);
  way.erase(std::unique(way.begin(), way.end()), way.end());
  for (const VehicleState& state : Moments(again, 0.1)) EXPECT_LT(DistanceFromPath(state.position, way), 0.1);
}

TEST(RearAxlePath, RefusesWhatIsNoDrive) {
  EXPECT_THROW(RearAxlePath({}, {}), InputError);
  EXPECT_THROW(RearAxlePath({{0, {}}}, {}), InputError);
  Trajectory still;
  for (int i = 0; i < 20; ++i) still.push_back({0.1 * i, {}});
  EXPECT_THROW(RearAxlePath(still, {}), InputError);
  Trajectory backwards = Record(Drive(StiffVehicle(), WayWithAStop(), FlatRoad, 0.3, 1), 0);
  backwards[5].time = backwards[4].time;
  EXPECT_THROW(RearAxlePath(backwards, {}), InputError);
}

}  // namespace
}  // namespace turnscale
