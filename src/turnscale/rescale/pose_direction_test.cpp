// SPDX-License-Identifier: MIT
#include "turnscale/rescale/pose_direction.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/rescale/test_rescale_drive.h"

namespace turnscale {
namespace {

Trajectory Inverse(Trajectory path) {
  for (StampedPose& pose : path) pose.world_from_camera = pose.world_from_camera.inverse();
  return path;
}

TEST(PoseDirection, IsToldByTurns) {
  const Eigen::Quaterniond aside = RotationFromYawPitchRoll({0.5, -0.2, 0.1});
  for (const int turns : {1, 3, 9}) {
    const Trajectory path = MakeScaledDrive(CityRoute(turns), kCar, aside, kUnit, {.position = 0.01}, 4).trajectory;
    EXPECT_FALSE(AreInverse({path})) << turns;
    EXPECT_TRUE(AreInverse({Inverse(path)})) << turns;
  }
}

TEST(PoseDirection, IsToldByABend) {
  const std::vector<DriveSegment> bend{{20, 0.9, 0}, {12, 0.9, 0.028}, {80, 0.9, 0}};
  const Trajectory path = MakeScaledDrive(bend, kCar, kIdentity, kUnit, {.position = 0.01}, 4).trajectory;
  EXPECT_FALSE(AreInverse({path}));
  EXPECT_TRUE(AreInverse({Inverse(path)}));
}

TEST(PoseDirection, ReversingAndStraightsAreNoReason) {
  const std::vector<DriveSegment> back{{60, 0.9, 0}, {40, -0.3, 0.05}, {30, 0.6, 0.05}, {40, -0.3, -0.04}};
  EXPECT_FALSE(AreInverse({MakeScaledDrive(back, kCar, kIdentity, kUnit, {.position = 0.01}).trajectory}));
  const Trajectory straight = MakeScaledDrive({{200, 0.9, 0}}, kCar, kIdentity, kUnit, {.position = 0.01}).trajectory;
  EXPECT_FALSE(AreInverse({straight}));
  EXPECT_FALSE(AreInverse({Inverse(straight)}));
  EXPECT_FALSE(AreInverse({Trajectory(30)})) << "stands";
}

// A camera that swings about all axes by some degrees (rms).
Trajectory Swinging(Trajectory path, double degrees, double period) {
  const double most = std::sqrt(2.0) * degrees / kDegreesPerRadian;
  for (StampedPose& pose : path) {
    const auto angle = [&](double rate, double phase) {
      return most * std::sin(2 * M_PI * rate * pose.time / period + phase);
    };
    pose.world_from_camera.rotation =
        pose.world_from_camera.rotation * RotationFromYawPitchRoll({angle(1, 0), angle(1.3, 1), angle(0.7, 2)});
  }
  return path;
}

TEST(PoseDirection, ACameraThatJittersOrSwingsIsNoReason) {
  const std::vector<DriveSegment> straight{{400, 0.9, 0}};
  const std::vector<DriveSegment> bends{{60, 0.9, 0.002}, {120, 0.9, -0.002}, {120, 0.9, 0.002}, {60, 0.9, -0.002}};
  for (const std::vector<DriveSegment>& segments : {straight, bends, CityRoute(1), CityRoute(4)})
    for (const double degrees : {2.0, 4.0, 6.0, 8.0}) {
      const DriveNoise jitter{.position = 0.01, .rotation = degrees / kDegreesPerRadian};
      EXPECT_FALSE(AreInverse({MakeScaledDrive(segments, kCar, kIdentity, kUnit, jitter).trajectory})) << degrees;
      const Trajectory path = MakeScaledDrive(segments, kCar, kIdentity, kUnit, {.position = 0.01}).trajectory;
      for (const double period : {3.0, 10.0, 30.0})
        EXPECT_FALSE(AreInverse({Swinging(path, degrees, period)})) << degrees << ' ' << period;
    }
}

TEST(PoseDirection, IsToldOfACameraThatJittersOrSwings) {
  for (const int turns : {1, 4, 9}) {
    const DriveNoise jitter{.position = 0.01, .rotation = 1 / kDegreesPerRadian};
    EXPECT_TRUE(AreInverse({Inverse(MakeScaledDrive(CityRoute(turns), kCar, kIdentity, kUnit, jitter).trajectory)}));
    const Trajectory path = MakeScaledDrive(CityRoute(turns), kCar, kIdentity, kUnit, {.position = 0.01}).trajectory;
    for (const double period : {3.0, 10.0}) EXPECT_TRUE(AreInverse({Inverse(Swinging(path, 2, period))})) << period;
  }
}

TEST(PoseDirection, ALongCarAndAFarOriginAreNoReason) {
  LeverArm bus = kCar;
  bus.length = 4;
  const std::vector<DriveSegment> slalom{{20, 0.5, 0.05}, {40, 0.5, -0.05}, {40, 0.5, 0.05}, {20, 0.5, -0.05}};
  for (const std::vector<DriveSegment>& segments : {slalom, CityRoute(4)})
    for (const double offset : {0.0, 1e3, 1e5}) {
      Trajectory path = MakeScaledDrive(segments, bus, kIdentity, kUnit, {.position = 0.005}, 4).trajectory;
      for (StampedPose& pose : path) pose.world_from_camera.translation.x() += offset;
      EXPECT_FALSE(AreInverse({path})) << offset;
    }
  Trajectory path = MakeScaledDrive(CityRoute(4), bus, kIdentity, kUnit, {.position = 0.005}, 4).trajectory;
  for (StampedPose& pose : path) pose.world_from_camera.translation.x() += 1e3;
  EXPECT_TRUE(AreInverse({Inverse(path)}));
}

TEST(PoseDirection, IsSaidWhateverRotationIsGiven) {
  const Trajectory path = Inverse(MakeScaledDrive(CityRoute(4), kCar, kIdentity, kUnit).trajectory);
  RescaleOptions options = OptionsFor(kCar);
  for (const bool given : {false, true}) {
    if (given) options.vehicle_from_camera = kIdentity;
    const RescaleResult result = RescaleTrajectory(options, path);
    EXPECT_FALSE(result.observable);
    EXPECT_NE(result.reason.find("camera_from_world"), std::string::npos) << result.reason;
  }
}

}  // namespace
}  // namespace turnscale
