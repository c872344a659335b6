// SPDX-License-Identifier: MIT
#include "turnscale/simulation/follow.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/simulation/test_routes.h"

namespace turnscale {
namespace {

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
