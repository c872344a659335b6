// SPDX-License-Identifier: MIT
#include "turnscale/odometry/mount_calibration.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/synthetic_drive.h"

namespace turnscale {
namespace {

constexpr double kBlockStep = M_PI / 2 / 30;
const Eigen::Quaterniond kTurned = RotationFromYawPitchRoll({0.15, -0.1, 0.03});

std::vector<DriveSegment> Blocks(int corners) {
  std::vector<DriveSegment> route = {{40, 0.8, 0}};
  for (int i = 0; i < corners; ++i) {
    route.push_back({30, 0.6, i % 2 == 0 ? kBlockStep : -kBlockStep});
    route.push_back({40, 0.8, 0});
  }
  return route;
}

void Append(const std::vector<DriveSegment>& route, const Eigen::Quaterniond& mount, Map& map) {
  const CarDrive drive = MakeCarDrive(route, 0.1, {1.2, 0.0045}, mount);
  const int first = CountKeyframes(map);
  const RigidTransform start =
      map.keyframes.empty() ? RigidTransform() : map.keyframes.back().camera_from_world.inverse();
  for (size_t i = first == 0 ? 0 : 1; i < drive.world_from_camera.size(); ++i) {
    const int k = CountKeyframes(map);
    map.keyframes.push_back({k, 0.1 * k, (start * drive.world_from_camera[i]).inverse(), {}, false});
  }
}

int Last(const Map& map) { return CountKeyframes(map) - 1; }

double DegreesBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b) * kDegreesPerRadian;
}

TEST(MountCalibration, FindsTheRotationInOneTurn) {
  Map map;
  Append(Blocks(1), kTurned, map);
  MountCalibration mount{VehicleOptions()};
  mount.Learn(map, 35);
  EXPECT_FALSE(mount.current().found) << "before the turn";
  mount.Learn(map, Last(map));
  EXPECT_TRUE(mount.current().found);
  EXPECT_LT(DegreesBetween(mount.At(0), kTurned), 1e-4);
  EXPECT_EQ(mount.mounts().size(), 1U);
  const Eigen::Quaterniond found = mount.At(0);
  mount.Learn(map, Last(map));
  EXPECT_EQ(mount.At(0).coeffs(), found.coeffs()) << "nothing new";
}

TEST(MountCalibration, KnowsBackingUpForWhatItIs) {
  Map map;
  Append(Blocks(1), kTurned, map);
  // The same way backwards in time.
  for (int k = 0; k < Last(map) - k; ++k) {
    std::swap(map.keyframes[k].camera_from_world, map.keyframes[Last(map) - k].camera_from_world);
  }
  MountCalibration mount{VehicleOptions()};
  mount.Learn(map, Last(map));
  EXPECT_TRUE(mount.current().found);
  EXPECT_LT(DegreesBetween(mount.At(0), kTurned), 1e-4);
}

// After a loss of tracking the map may go on in another unit.
TEST(MountCalibration, ANewUnitBeyondAGapDoesNotMatter) {
  Map map;
  Append(Blocks(3), kTurned, map);
  constexpr std::size_t kGap = 50;  // in the middle of a turn
  Map plain = map;
  plain.keyframes[kGap].after_gap = true;
  Map scaled = map;
  for (std::size_t k = 1; k < map.keyframes.size(); ++k) {
    RigidTransform step = map.keyframes[k].camera_from_world * map.keyframes[k - 1].camera_from_world.inverse();
    if (k >= kGap) step.translation *= 4;
    scaled.keyframes[k].camera_from_world = step * scaled.keyframes[k - 1].camera_from_world;
  }
  scaled.keyframes[kGap].after_gap = true;
  MountCalibration of_plain{VehicleOptions()};
  MountCalibration of_scaled{VehicleOptions()};
  of_plain.Learn(plain, Last(map));
  of_scaled.Learn(scaled, Last(map));
  EXPECT_LT(DegreesBetween(of_scaled.At(0), of_plain.At(0)), 1e-4);
}

TEST(MountCalibration, AGivenRotationStays) {
  VehicleOptions vehicle;
  vehicle.calibrate_camera = false;
  Map map;
  Append(Blocks(2), kTurned, map);
  MountCalibration mount(vehicle);
  mount.Learn(map, Last(map));
  EXPECT_EQ(mount.At(Last(map)).coeffs(), vehicle.vehicle_from_camera.coeffs());
}

TEST(MountCalibration, AKnownYawIsAveragedWithTheDrivesUnlessTheyContradict) {
  Map map;
  Append(Blocks(2), kTurned, map);
  const auto yaw_found = [&](double known_error, double known_sigma) {
    VehicleOptions vehicle;
    vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.15 + known_error, -0.1, 0.03});
    vehicle.camera_known = true;
    vehicle.yaw_sigma = known_sigma;
    MountCalibration mount(vehicle);
    mount.Learn(map, Last(map));
    EXPECT_TRUE(mount.current().found);
    return std::pair(YawPitchRollFromRotation(mount.At(0)).yaw - 0.15, mount.current().sigma.yaw);
  };
  MountCalibration alone{VehicleOptions()};
  alone.Learn(map, Last(map));
  const double own = alone.current().sigma.yaw;
  const auto [yaw, sigma] = yaw_found(own, own);
  constexpr double kLeastChange = 0.05 / kDegreesPerRadian;  // that is taken over
  EXPECT_NEAR(yaw, 0.5 * own, kLeastChange);
  EXPECT_NEAR(sigma, own / std::sqrt(2), 0.01 * own);
  EXPECT_NEAR(yaw_found(10 * own, own).first, 0, 0.1 * own) << "another camera";
}

TEST(MountCalibration, KnownPitchAndRollAreAveragedWithTheDrives) {
  Map map;
  Append(Blocks(2), kTurned, map);
  MountCalibration alone{VehicleOptions()};
  alone.Learn(map, Last(map));
  const YawPitchRoll own = alone.current().sigma;
  VehicleOptions vehicle;
  vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.15, -0.1 + own.pitch, 0.03 + own.roll});
  vehicle.camera_known = true;
  vehicle.known_pitch_sigma = 0.1 * own.pitch;
  vehicle.known_roll_sigma = 0.1 * own.roll;
  MountCalibration mount(vehicle);
  mount.Learn(map, Last(map));
  ASSERT_TRUE(mount.current().found);
  const YawPitchRoll found = YawPitchRollFromRotation(mount.At(0));
  EXPECT_NEAR(found.pitch, -0.1 + own.pitch, 0.05 * own.pitch);
  EXPECT_NEAR(found.roll, 0.03 + own.roll, 0.05 * own.roll);
  EXPECT_NEAR(mount.current().sigma.roll, 0.1 * own.roll, 0.01 * own.roll);
  // A camera that was turned aside, and rolled by less than would show.
  vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.15 + 0.2, -0.1, 0.03 + own.roll});
  MountCalibration aside(vehicle);
  aside.Learn(map, Last(map));
  EXPECT_NEAR(YawPitchRollFromRotation(aside.At(0)).roll, 0.03, 0.1 * own.roll);
  // A camera that hangs otherwise.
  vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.15, -0.1, 0.03 + 10 * own.roll});
  MountCalibration turned(vehicle);
  turned.Learn(map, Last(map));
  EXPECT_NEAR(YawPitchRollFromRotation(turned.At(0)).roll, 0.03, 0.1 * own.roll);
}

TEST(LooksAlong, AheadOrBackHoweverItIsPitchedOrRolled) {
  const auto looks = [](double yaw_deg, double pitch_deg, double roll_deg) {
    return LooksAlong(RotationFromYawPitchRoll(
        {yaw_deg / kDegreesPerRadian, pitch_deg / kDegreesPerRadian, roll_deg / kDegreesPerRadian}));
  };
  for (const double yaw : {0.0, 38.0, -38.0, 142.0, 180.0}) EXPECT_TRUE(looks(yaw, 0, 0)) << yaw;
  for (const double yaw : {42.0, -61.0, 90.0, 138.0}) EXPECT_FALSE(looks(yaw, 0, 0)) << yaw;
  EXPECT_TRUE(looks(10, -45, 0)) << "down at the road";
  EXPECT_TRUE(looks(-10, 5, 90));
}

TEST(MountCalibration, AMovedCameraIsAnotherMount) {
  const Eigen::Quaterniond moved = RotationFromYawPitchRoll({0.15 + 0.06, -0.1 + 0.03, 0.03});
  Map map;
  Append(Blocks(5), kTurned, map);
  const int at = Last(map);
  Append(Blocks(5), moved, map);
  MountCalibration mount{VehicleOptions()};
  mount.Learn(map, Last(map));
  EXPECT_EQ(mount.moves(), 1);
  ASSERT_EQ(mount.mounts().size(), 2U);
  EXPECT_NEAR(mount.mounts()[1].first_keyframe, at, 20) << "two seconds";
  EXPECT_LT(DegreesBetween(mount.At(at - 20), kTurned), 1e-4) << "nothing of what follows the move";
  EXPECT_LT(DegreesBetween(mount.At(Last(map)), moved), 0.003);
}

TEST(MountCalibration, AfterAJumpTheRotationIsKnownAtOnce) {
  const Eigen::Quaterniond jump = RotationFromYawPitchRoll({0.03, -0.02, 0.01});
  Map map;
  Append(Blocks(2), kTurned, map);
  const int at = CountKeyframes(map);
  Append(Blocks(2), kTurned, map);
  for (int k = at; k < CountKeyframes(map); ++k) {
    RigidTransform pose = map.keyframes[k].camera_from_world.inverse();
    pose.rotation = pose.rotation * jump;
    map.keyframes[k].camera_from_world = pose.inverse();
  }
  MountCalibration mount{VehicleOptions()};
  mount.Learn(map, at - 1);
  MountCalibration copy = mount;
  mount.AddJump(at, {.first_frame = at, .before_from_after = jump});
  EXPECT_LT(DegreesBetween(mount.At(at - 1), kTurned), 1e-3);
  EXPECT_LT(DegreesBetween(mount.At(at), kTurned * jump), 1e-3);
  EXPECT_LT(DegreesBetween(mount.current().vehicle_from_camera, kTurned * jump), 1e-3);
  EXPECT_EQ(mount.jumps().size(), 1U);
  EXPECT_FALSE(mount.HasJumpsMissedBy(copy));
  MountCalibration ignorant = copy;
  ignorant.Learn(map, at);
  EXPECT_TRUE(mount.HasJumpsMissedBy(ignorant));
  copy.TakeJumps(mount);
  copy.Learn(map, Last(map));
  EXPECT_EQ(copy.moves(), 0) << "nothing is found anew";
  EXPECT_LT(DegreesBetween(copy.At(at - 1), kTurned), 1e-3);
  EXPECT_LT(DegreesBetween(copy.At(Last(map)), kTurned * jump), 1e-3);
}

}  // namespace
}  // namespace turnscale
