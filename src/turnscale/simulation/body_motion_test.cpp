// SPDX-License-Identifier: MIT
#include "turnscale/simulation/body_motion.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/simulation/test_routes.h"

namespace turnscale {
namespace {

YawPitchRoll AnglesAt(const VehicleMotion& motion, double time) {
  return YawPitchRollFromRotation(motion.At(time).world_from_vehicle.rotation);
}

TEST(Suspension, SwingsPastItsTargetAndSettles) {
  Suspension suspension;
  double greatest = 0;
  for (int i = 0; i < 1500; ++i) {
    suspension.Step(0.01, 1.4, 0.002);
    greatest = std::max(greatest, suspension.angle);
  }
  EXPECT_NEAR(greatest, 0.01 * (1 + std::exp(-M_PI * 0.4 / std::sqrt(1 - 0.16))), 1e-4);
  EXPECT_NEAR(suspension.angle, 0.01, 1e-5);
  for (int i = 0; i < 2000; ++i) suspension.Step(0, 1.4, 0.002);
  EXPECT_EQ(suspension.angle, 0);
  EXPECT_EQ(suspension.rate, 0);
}

TEST(RoadNoise, HasUnitVarianceAndIsSmooth) {
  for (const unsigned seed : {1u, 2u, 77u}) {
    const RoadNoise noise(seed);
    double squares = 0;
    double sum = 0;
    double steepest = 0;
    constexpr int kCount = 50000;
    for (int i = 0; i < kCount; ++i) {
      const double value = noise.At(0.05 * i);
      sum += value;
      squares += value * value;
      steepest = std::max(steepest, std::abs(value - noise.At(0.05 * i + 0.01)));
    }
    EXPECT_NEAR(sum / kCount, 0, 0.02);
    EXPECT_NEAR(squares / kCount, 1, 0.1);
    EXPECT_LT(steepest, 0.01 * 2 * M_PI / 2 * 7) << "no waves shorter than 2 m";
  }
  EXPECT_EQ(RoadNoiseGain(10), 1);
  EXPECT_EQ(RoadNoiseGain(0), 0);
  EXPECT_EQ(RoadNoiseGain(-4), RoadNoiseGain(4));
}

TEST(Body, NodsWithTheAcceleration) {
  CarOptions options;
  options.road_noise_deg = 0;
  const VehicleMotion motion = DriveFlat(options, {Straight(60, 12)});
  double up = 0;
  double down = 0;
  for (const VehicleState& state : Moments(motion, 0.02)) {
    const double pitch = YawPitchRollFromRotation(state.world_from_vehicle.rotation).pitch * kDegreesPerRadian;
    (state.time < 0.5 * motion.duration() ? up : down) += pitch;
    if (std::abs(state.time - 4) < 0.011) {
      EXPECT_NEAR(pitch, 4 * 1.8 / 9.81, 0.05) << "nose up, steadily accelerating";
    }
  }
  EXPECT_GT(up, 0);
  EXPECT_LT(down, 0);

  RouteLeg reverse = Straight(10, 2);
  reverse.reverse = true;
  EXPECT_LT(AnglesAt(DriveFlat(options, {reverse}), 1.2).pitch, 0) << "backwards it nods the other way";
}

TEST(Body, LeansOutwards) {
  CarOptions options;
  options.road_noise_deg = 0;
  const VehicleMotion right = DriveFlat(options, {Circle(10, 5, 1)});
  EXPECT_NEAR(AnglesAt(right, 9).roll * kDegreesPerRadian, -5 * 2.5 / 9.81, 0.05);
  RouteLeg circle = Circle(10, 5, 1);
  for (Eigen::Vector2d& point : circle.points) point.x() *= -1;
  EXPECT_NEAR(AnglesAt(DriveFlat(options, {circle}), 9).roll, -AnglesAt(right, 9).roll, 1e-9);
}

TEST(Body, UnevennessHasItsSizeAtTenMetresPerSecond) {
  CarOptions options = StiffVehicle();
  options.road_noise_deg = 0.1;
  RouteLeg leg = Straight(2000, 10);
  leg.speeds = {10, 10};
  const VehicleMotion motion = DriveFlat(options, {leg});
  double pitch = 0;
  double roll = 0;
  const std::vector<VehicleState> states = Moments(motion, 0.02);
  for (const VehicleState& state : states) {
    const YawPitchRoll angles = YawPitchRollFromRotation(state.world_from_vehicle.rotation);
    pitch += angles.pitch * angles.pitch;
    roll += angles.roll * angles.roll;
  }
  const auto count = static_cast<double>(states.size());
  EXPECT_NEAR(std::sqrt(pitch / count) * kDegreesPerRadian, 0.1, 0.01);
  EXPECT_NEAR(std::sqrt(roll / count) * kDegreesPerRadian, 0.1, 0.01);
}

TEST(Body, FollowsTheRoad) {
  const auto ramp = [](const Eigen::Vector2d& place) { return 0.1 * std::clamp(place.y() - 20, 0.0, 20.0); };
  const VehicleMotion motion = Drive(StiffVehicle(), {Straight(60, 5)}, ramp, 0.3, 1);
  for (const VehicleState& state : Moments(motion, 0.1)) {
    const double z = state.position.y();
    const Eigen::Vector3d place(0, -ramp(state.position) - 0.3, z);
    EXPECT_NEAR((state.world_from_vehicle.translation - place).norm(), 0, 1e-9);
    const double pitch = YawPitchRollFromRotation(state.world_from_vehicle.rotation).pitch;
    if (z > 20 && z < 37) {
      EXPECT_NEAR(std::tan(pitch), 0.1, 1e-12) << "nose up";
    }
    if (z < 17 || z > 40) {
      EXPECT_NEAR(pitch, 0, 1e-12);
    }
  }

  const auto crowned = [](const Eigen::Vector2d& place) { return -0.03 * std::abs(place.x() + 2); };
  const VehicleMotion beside = Drive(StiffVehicle(), {Straight(10, 5)}, crowned, 0.3, 1);
  EXPECT_NEAR(std::tan(AnglesAt(beside, 2).roll), 0.03, 1e-12) << "down to the right, right of the crown";
  EXPECT_NEAR(AnglesAt(beside, 2).pitch, 0, 1e-12);
}

}  // namespace
}  // namespace turnscale
