// SPDX-License-Identifier: MIT
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/simulation/reference_path.h"
#include "turnscale/simulation/test_routes.h"

namespace turnscale {
namespace {

/// Greatest distance of the rear axle from the legs' points.
double GreatestError(const VehicleMotion& motion, const std::vector<RouteLeg>& legs) {
  double greatest = 0;
  for (const VehicleState& state : Moments(motion, 0.05)) {
    double error = std::numeric_limits<double>::infinity();
    for (const RouteLeg& leg : legs) error = std::min(error, DistanceFromPath(state.position, leg.points));
    greatest = std::max(greatest, error);
  }
  return greatest;
}

RouteLeg CornersLeg(double speed) {
  RouteLeg leg;
  leg.points = RoundCorners({{0, 0}, {0, 30}, {25, 30}, {25, 0}, {60, 0}, {60, 40}}, 6, 0.5);
  leg.speed = speed;
  return leg;
}

/// Two half circles with nothing between them.
RouteLeg SLeg(double radius, double speed) {
  RouteLeg leg;
  leg.points = Arc({radius, 15}, radius, M_PI, 0);
  leg.points.insert(leg.points.begin(), Eigen::Vector2d(0, 0));
  const std::vector<Eigen::Vector2d> second = Arc({3 * radius, 15}, radius, -M_PI, 0);
  leg.points.insert(leg.points.end(), second.begin() + 1, second.end());
  leg.points.emplace_back(4 * radius, 30);
  leg.speed = speed;
  return leg;
}

/// Backwards round a corner, and away forwards.
std::vector<RouteLeg> LeavingAParkingSpace() {
  RouteLeg out;
  out.points = RoundCorners({{0, 0}, {0, -9}, {14, -9}}, 6, 0.3);
  out.speed = 2;
  out.reverse = true;
  out.wait = 1;
  RouteLeg away;
  away.points = {{14, -9}, {-30, -9}};
  return {out, away};
}

TEST(PathFollowing, StaysOnCornersAtAnySpeed) {
  for (const double speed : {0.2, 3.0, 5.0, 8.0}) {
    const RouteLeg leg = CornersLeg(speed);
    const VehicleMotion motion = DriveFlat({}, {leg});
    EXPECT_LT(GreatestError(motion, {leg}), 0.05) << speed;
    EXPECT_LT((motion.At(motion.duration()).position - leg.points.back()).norm(), 0.05);
    EXPECT_EQ(motion.At(0).speed, 0);
    EXPECT_EQ(motion.At(motion.duration()).speed, 0);
    for (const VehicleState& state : Moments(motion, 0.1)) EXPECT_LT(state.speed, 1.005 * speed);
  }
}

TEST(PathFollowing, StaysOnAnS) {
  for (const double slip : {0.0, 3.0, 6.0}) {
    CarOptions options;
    options.slip_deg_per_g = slip;
    EXPECT_LT(GreatestError(DriveFlat(options, {SLeg(5.5, 6)}), {SLeg(5.5, 6)}), 0.1) << slip;
    EXPECT_LT(GreatestError(DriveFlat(options, {SLeg(30, 14)}), {SLeg(30, 14)}), 0.1) << slip;
  }
}

TEST(PathFollowing, BacksOutOfAParkingSpace) {
  const std::vector<RouteLeg> legs = LeavingAParkingSpace();
  const VehicleMotion motion = DriveFlat({}, legs);
  EXPECT_LT(GreatestError(motion, legs), 0.05);
  EXPECT_LT((motion.At(motion.duration()).position - legs[1].points.back()).norm(), 0.05);
  double least = 0;
  for (const VehicleState& state : Moments(motion, 0.1)) least = std::min(least, state.speed);
  EXPECT_NEAR(least, -2, 0.02);
  EXPECT_NEAR(motion.At(motion.duration()).heading, -M_PI / 2, 0.01);
}

TEST(PathFollowing, KeepsTheLimits) {
  const CarOptions options;
  for (const std::vector<RouteLeg>& legs :
       {std::vector<RouteLeg>{CornersLeg(8)}, {SLeg(6, 8)}, {SLeg(40, 20)}, LeavingAParkingSpace()}) {
    const double interval = 0.01;
    const std::vector<VehicleState> states = Moments(DriveFlat(options, legs), interval);
    double last = 0;
    for (std::size_t i = 1; i < states.size(); ++i) {
      const double acceleration = (states[i].speed - states[i - 1].speed) / interval;
      const bool faster = std::abs(states[i].speed) > std::abs(states[i - 1].speed);
      EXPECT_LT(std::abs(acceleration), 1.02 * (faster ? options.max_acceleration : options.max_deceleration));
      EXPECT_LT(std::abs(acceleration - last), 10 * interval) << "jerk";
      EXPECT_LT(std::abs(states[i].speed * states[i].yaw_rate), options.max_lateral_acceleration);
      EXPECT_LE(std::abs(states[i].steering) * kDegreesPerRadian, options.max_steering_deg);
      EXPECT_LE(std::abs(states[i].steering - states[i - 1].steering) * kDegreesPerRadian,
                options.max_steering_rate_deg * interval * (1 + 1e-9));
      last = acceleration;
    }
  }
}

TEST(PathFollowing, RecordingsKeepTheirSpeedsAndNoiseStaysOutOfTheSteering) {
  RouteLeg leg;
  // A wavy road recorded at 10 Hz by a car of 8 to 12 m/s, with centimetres of noise.
  double z = 0;
  for (int i = 0; i < 300; ++i) {
    const double speed = 10 + 2 * std::cos(0.03 * i);
    const double noise = 0.02 * std::sin(static_cast<double>(i) * i);
    leg.points.emplace_back(5 * std::sin(0.05 * z) + noise, z);
    leg.speeds.push_back(speed);
    z += 0.1 * speed;
  }
  const VehicleMotion motion = DriveFlat({}, {leg});
  EXPECT_NEAR(motion.At(0).speed, 12, 0.02);
  EXPECT_NEAR(motion.At(motion.duration()).speed, leg.speeds.back(), 0.05);
  EXPECT_LT(GreatestError(motion, {leg}), 0.15);
  std::vector<VehicleState> states = Moments(motion, 0.1);
  for (std::size_t i = 1; i < states.size(); ++i)
    EXPECT_LT(std::abs(states[i].steering - states[i - 1].steering) * kDegreesPerRadian, 1);
}

TEST(PathFollowing, CreepsThroughARecordedStop) {
  RouteLeg leg = Straight(0, 5);
  leg.points = {{0, 0}, {0, 10}, {0, 20}, {0, 30}};
  leg.speeds = {5, 0, 0, 5};
  const VehicleMotion motion = DriveFlat({}, {leg});
  EXPECT_NEAR(motion.At(motion.duration()).position.y(), 30, 0.1);
  double slowest = 5;
  for (const VehicleState& state : Moments(motion, 0.1)) slowest = std::min(slowest, state.speed);
  EXPECT_NEAR(slowest, 0.2, 0.01);
}

TEST(ReferencePath, HasTheCurvatureOfItsPoints) {
  const ReferencePath path = MakeReferencePath(Circle(8, 5, 0.5));
  for (double distance = 3; distance < path.Length() - 3; distance += 0.37) {
    const PathPlace place = PlaceAt(path, distance);
    EXPECT_NEAR(place.curvature * 8, 1, 0.01);
    EXPECT_NEAR((place.position - Eigen::Vector2d(8, 0)).norm(), 8, 0.03);
    const Eigen::Vector2d right(std::cos(place.heading), -std::sin(place.heading));
    EXPECT_NEAR(Project(path, place.position + 0.3 * right, distance + 0.1), distance, 0.01);
  }
  EXPECT_NEAR((path.position.front() - Circle(8, 5, 0.5).points.front()).norm(), 0, 1e-12);
  EXPECT_EQ(PlaceAt(path, -1).curvature, 0);
  EXPECT_NEAR((PlaceAt(path, -1).position - path.position.front()).norm(), 1, 1e-12);
}

}  // namespace
}  // namespace turnscale
