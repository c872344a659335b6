// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_scale.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/synthetic_drive.h"

namespace turnscale {
namespace {

constexpr double kQuarter = M_PI / 2 / 30;
constexpr double kUnit = 0.25;  // of the start, per metre
const Eigen::Quaterniond kTurned = RotationFromYawPitchRoll({0.15, -0.1, 0.03});
const LeverArm kCar{1.2, 0.0045};

// In the unit of the start up to keyframe `change`, then in metres.
Map MapOfDrive(int change, std::vector<double>& units) {
  const CarDrive drive = MakeCarDrive(
      {{40, 0.8, 0}, {30, 0.6, kQuarter}, {60, 0.8, 0}, {30, 0.6, -kQuarter}, {20, 0.8, 0}}, 0.1, kCar, kTurned);
  Map map;
  for (int k = 0; k < static_cast<int>(drive.world_from_camera.size()); ++k) {
    units.push_back(k > change ? 1 / kUnit : 1);
    RigidTransform pose;
    if (k > 0) {
      RigidTransform step = drive.world_from_camera[k].inverse() * drive.world_from_camera[k - 1];
      step.translation *= units[k] * kUnit;
      pose = step * map.keyframes.back().camera_from_world;
    }
    map.keyframes.push_back({k, 0.1 * k, pose, {}, false});
  }
  return map;
}

OdometryOptions Car() {
  OdometryOptions options;
  VehicleOptions& vehicle = options.vehicle;
  vehicle.lever_arm = kCar.length;
  vehicle.side_slip_sigma = 0;
  vehicle.vehicle_from_camera = kTurned;
  vehicle.calibrate_camera = false;
  return options;
}

TEST(DriveScale, IsPerUnitOfTheStart) {
  std::vector<double> units;
  const Map map = MapOfDrive(75, units);
  const std::optional<DriveScale> drive = DriveScaleOf(map, units, MountCalibration(Car().vehicle), Car());
  ASSERT_TRUE(drive);
  const std::vector<PoseScale>& scales = drive->keyframes;
  ASSERT_EQ(scales.size(), map.keyframes.size());
  for (const PoseScale& scale : scales) EXPECT_NEAR(scale.metres_per_unit * kUnit, 1, 0.003);
}

TEST(DriveScale, ReadsNothingAcrossAGap) {
  std::vector<double> units;
  Map map = MapOfDrive(75, units);
  // Tracking was lost on the straight, and found again three times as large.
  map.keyframes[90].after_gap = true;
  for (size_t k = 90; k < units.size(); ++k) units[k] /= 3;
  const std::optional<DriveScale> drive = DriveScaleOf(map, units, MountCalibration(Car().vehicle), Car());
  ASSERT_TRUE(drive);
  const std::vector<PoseScale>& scales = drive->keyframes;
  ASSERT_EQ(scales.size(), map.keyframes.size());
  // A yaw that is off could have each of the turns read a little wrong.
  EXPECT_NEAR(scales[50].metres_per_unit * kUnit, 1, 0.03);
  EXPECT_NEAR(scales[140].metres_per_unit * kUnit * 3, 1, 0.03);
}

TEST(DriveScale, WithoutALeverArmThereIsNone) {
  std::vector<double> units;
  const Map map = MapOfDrive(75, units);
  OdometryOptions car = Car();
  car.vehicle.lever_arm.reset();
  EXPECT_FALSE(DriveScaleOf(map, units, MountCalibration(car.vehicle), car));
}

}  // namespace
}  // namespace turnscale
