// SPDX-License-Identifier: MIT
#include "turnscale/simulation/vehicle.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/pooled_line.h"
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

constexpr double kMoment = 0.002;
constexpr double kLeverArm = 1.45;

Eigen::Vector3d CameraAt(const VehicleMotion& motion, double time) {
  return motion.At(time).world_from_vehicle * Eigen::Vector3d(0, 0, kLeverArm);
}

/// The camera's sideways velocity against what slip leaves of the lever arm, m/s.
double SidewaysError(const VehicleMotion& motion, double side_slip, double time) {
  const VehicleState state = motion.At(time);
  const Eigen::Vector3d velocity =
      (CameraAt(motion, time + kMoment) - CameraAt(motion, time - kMoment)) / (2 * kMoment);
  const double sideways = (state.world_from_vehicle.rotation.conjugate() * velocity).x();
  return sideways - state.yaw_rate * (kLeverArm - side_slip * std::abs(state.speed) * state.speed);
}

std::vector<VehicleStep> StepsOf(const VehicleMotion& motion) {
  std::vector<VehicleStep> steps;
  const RigidTransform vehicle_from_camera{Eigen::Quaterniond::Identity(), {0, 0, kLeverArm}};
  for (double time = 0.1; time < motion.duration(); time += 0.1) {
    const RigidTransform before = motion.At(time - 0.1).world_from_vehicle * vehicle_from_camera;
    const RigidTransform after = motion.At(time).world_from_vehicle * vehicle_from_camera;
    steps.push_back({TurningMotionOf(before.inverse() * after, Eigen::Quaterniond::Identity()), 0.1});
  }
  return steps;
}

TEST(Vehicle, TurnsAndSlipsOnACircle) {
  const CarOptions options = StiffVehicle();
  const VehicleMotion motion = DriveFlat(options, {Circle(10, 5, 1)});
  const VehicleState state = motion.At(0.5 * motion.duration());
  EXPECT_NEAR(state.speed, 5, 0.02);
  EXPECT_NEAR(state.yaw_rate / (state.speed / 10), 1, 0.01);
  EXPECT_NEAR(std::tan(state.steering), options.wheelbase * state.yaw_rate / state.speed, 1e-12);
  const double lateral_g = state.speed * state.yaw_rate / 9.81;
  EXPECT_NEAR(state.slip * kDegreesPerRadian / lateral_g, -options.slip_deg_per_g, 1e-3) << "to the left";
  const Eigen::Vector2d travel = motion.At(state.time + kMoment).position - motion.At(state.time - kMoment).position;
  EXPECT_NEAR(std::remainder(std::atan2(travel.x(), travel.y()) - state.heading - state.slip, 2 * M_PI), 0, 1e-6);
}

TEST(Vehicle, CameraSwingsByTheEffectiveLeverArm) {
  for (const bool reverse : {false, true}) {
    RouteLeg leg = Circle(10, 5, 0.6);
    leg.reverse = reverse;
    const CarOptions options = StiffVehicle();
    const VehicleMotion motion = DriveFlat(options, {leg});
    const VehicleState middle = motion.At(0.5 * motion.duration());
    EXPECT_EQ(middle.speed < 0, reverse);
    EXPECT_GT(middle.yaw_rate, 0.4) << "the way bends to the right";
    // Where the turning is even; elsewhere finite differences see its change.
    const double start = kMoment * std::round((middle.time - 0.5) / kMoment);
    for (int i = 0; i < 500; ++i) EXPECT_NEAR(SidewaysError(motion, options.SideSlip(), start + i * kMoment), 0, 1e-6);
  }
}

TEST(Vehicle, PooledLineGivesBackTheLeverArm) {
  RouteLeg corner;
  corner.points = RoundCorners({{0, 0}, {0, 20}, {20, 20}}, 6, 0.5);
  corner.speed = 2;
  CarOptions options = StiffVehicle();
  options.slip_deg_per_g = 0;
  const std::vector<VehicleStep> rigid = StepsOf(DriveFlat(options, {corner}));
  const PooledLine line = PoolTurn(rigid, {}).line.value();
  EXPECT_NEAR(line.lever_arm / kLeverArm, 1, 1e-3);
  EXPECT_NEAR(MetresPerUnit(line, {kLeverArm, 0}), 1, 1e-3);

  corner.speed = 5;
  options.slip_deg_per_g = 3;
  const std::vector<VehicleStep> slipping = StepsOf(DriveFlat(options, {corner}));
  const PooledLine shortened = PoolTurn(slipping, {}).line.value();
  EXPECT_LT(shortened.lever_arm / kLeverArm, 0.97);
  EXPECT_NEAR(MetresPerUnit(shortened, {kLeverArm, options.SideSlip()}), 1, 3e-3);
}

TEST(Vehicle, StandstillIsExact) {
  RouteLeg out = Circle(8, 5, 0.2);
  out.wait = 8;
  RouteLeg back = out;
  std::reverse(back.points.begin(), back.points.end());
  back.reverse = true;
  const VehicleMotion motion = DriveFlat({}, {out, back});
  double stopped = 0;
  while (motion.At(stopped).speed != 0 || stopped < 1) stopped += kMoment;
  const VehicleState rest = motion.At(stopped + 5);
  for (double time = stopped + 5; time < stopped + 7.99; time += 0.0137) {
    const VehicleState state = motion.At(time);
    EXPECT_EQ(state.speed, 0);
    EXPECT_EQ(state.yaw_rate, 0);
    EXPECT_EQ(state.steering, rest.steering);
    EXPECT_EQ(state.heading, rest.heading);
    EXPECT_EQ(state.position, rest.position);
    EXPECT_EQ(state.world_from_vehicle.translation, rest.world_from_vehicle.translation);
    EXPECT_EQ(state.world_from_vehicle.rotation.coeffs(), rest.world_from_vehicle.rotation.coeffs());
  }
  EXPECT_NE(motion.At(stopped + 9.5).position, rest.position) << "it drives on";
  EXPECT_EQ(motion.At(motion.duration() + 1).position, motion.At(motion.duration()).position);
  EXPECT_EQ(motion.At(-1).position, motion.At(0).position);
}

TEST(Vehicle, InterpolationIsFineEnough) {
  RouteLeg corner;
  corner.points = RoundCorners({{0, 0}, {0, 30}, {30, 30}}, 6, 0.5);
  const VehicleMotion motion = DriveFlat({}, {corner});
  const VehicleMotion coarse(Moments(motion, 2 * kMoment), 2 * kMoment);
  for (double time = kMoment; time < coarse.duration(); time += 2 * kMoment) {
    const RigidTransform exact = motion.At(time).world_from_vehicle;
    const RigidTransform between = coarse.At(time).world_from_vehicle;
    EXPECT_LT((exact.translation - between.translation).norm(), 1e-5);
    // At twice the interval the error is four times as large.
    EXPECT_LT(RotationAngle(exact.rotation.conjugate() * between.rotation), 4e-6);
  }
}

TEST(Vehicle, SameSeedSameBitsOtherSeedOtherUnevenness) {
  RouteLeg corner;
  corner.points = RoundCorners({{0, 0}, {0, 20}, {20, 20}}, 6, 0.5);
  const VehicleMotion first = DriveFlat({}, {corner}, 7);
  const VehicleMotion same = DriveFlat({}, {corner}, 7);
  const VehicleMotion other = DriveFlat({}, {corner}, 8);
  EXPECT_EQ(first.duration(), other.duration());
  double difference = 0;
  for (double time = 0; time < first.duration(); time += 0.01) {
    const RigidTransform pose = first.At(time).world_from_vehicle;
    const RigidTransform other_pose = other.At(time).world_from_vehicle;
    EXPECT_EQ(pose.translation, same.At(time).world_from_vehicle.translation);
    EXPECT_EQ(pose.rotation.coeffs(), same.At(time).world_from_vehicle.rotation.coeffs());
    EXPECT_EQ(pose.translation, other_pose.translation);
    EXPECT_EQ(first.At(time).heading, other.At(time).heading);
    difference = std::max(difference, RotationAngle(pose.rotation.conjugate() * other_pose.rotation));
  }
  EXPECT_GT(difference * kDegreesPerRadian, 0.03);
}

TEST(Vehicle, RefusesLegsThatCannotBeDriven) {
  EXPECT_THROW(DriveFlat({}, {}), InternalError);
  EXPECT_THROW(DriveFlat({}, {RouteLeg{}}), InputError);
  EXPECT_THROW(DriveFlat({}, {Straight(10, 5), Straight(10, 5)}), InternalError) << "the second starts elsewhere";
  EXPECT_THROW(DriveFlat({}, {Circle(1, 2, 1)}), InputError) << "too tight";
  EXPECT_THROW(VehicleMotion({}, 0.002), InternalError);
  EXPECT_THROW(VehicleMotion({VehicleState{}}, 0), InternalError);
}

TEST(Vehicle, ComplaintsAboutLegsSayWhere) {
  const auto complaint = [](const RouteLeg& leg) {
    try {
      DriveFlat({}, {leg});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  RouteLeg bend;
  bend.points = {{0, 0}, {0, 30}};
  for (const Eigen::Vector2d& point : Arc({1.5, 30}, 1.5, M_PI, 0)) bend.points.push_back(point);
  bend.points.emplace_back(3, 0);
  const std::string sharp = complaint(bend);
  ASSERT_EQ(sharp.find("legs: "), 0u) << sharp;
  EXPECT_NEAR(std::stod(sharp.substr(6)), 33, 3) << sharp;
  RouteLeg recorded = Straight(0, 5);
  recorded.points = {{0, 0}, {0, 10}, {0, 20}};
  recorded.speeds = {5, 250, 5};
  EXPECT_EQ(complaint(recorded).find("leg.speeds: is 250 m/s after 10.0 m; it has to be in 0...100 m/s"), 0u)
      << complaint(recorded);
}

TEST(Vehicle, CheckNamesTheField) {
  EXPECT_NO_THROW(CarOptions{}.Check());
  const auto refused = [](auto change) { return RefusedField<CarOptions>(change); };
  EXPECT_EQ(refused([](CarOptions& o) { o.wheelbase = 0; }), "vehicle.wheelbase");
  EXPECT_EQ(refused([](CarOptions& o) { o.max_steering_deg = 90; }), "vehicle.max_steering_deg");
  EXPECT_EQ(refused([](CarOptions& o) { o.max_steering_rate_deg = 0; }), "vehicle.max_steering_rate_deg");
  EXPECT_EQ(refused([](CarOptions& o) { o.slip_deg_per_g = -1; }), "vehicle.slip_deg_per_g");
  EXPECT_EQ(refused([](CarOptions& o) { o.max_acceleration = 0; }), "vehicle.max_acceleration");
  EXPECT_EQ(refused([](CarOptions& o) { o.max_deceleration = std::nan(""); }), "vehicle.max_deceleration");
  EXPECT_EQ(refused([](CarOptions& o) { o.max_lateral_acceleration = 0; }), "vehicle.max_lateral_acceleration");
  EXPECT_EQ(refused([](CarOptions& o) { o.pitch_deg_per_g = -1; }), "vehicle.pitch_deg_per_g");
  EXPECT_EQ(refused([](CarOptions& o) { o.roll_deg_per_g = 90; }), "vehicle.roll_deg_per_g");
  EXPECT_EQ(refused([](CarOptions& o) { o.suspension_hz = 0; }), "vehicle.suspension_hz");
  EXPECT_EQ(refused([](CarOptions& o) { o.road_noise_deg = -0.1; }), "vehicle.road_noise_deg");
}

}  // namespace
}  // namespace turnscale
