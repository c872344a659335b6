// SPDX-License-Identifier: MIT
#include "turnscale/rescale/rescale.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/rescale/drifting_drive.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kIdentity = Eigen::Quaterniond::Identity();
const LeverArm kCar{1.2, 0.004};
constexpr double kUnit = 17.0;

RescaleOptions OptionsFor(const LeverArm& car) {
  RescaleOptions options;
  options.car.lever_arm = car.length;
  options.car.side_slip = car.side_slip;
  return options;
}

double WorstLogError(const RescaleResult& result, const ScaledDrive& drive) {
  double worst = 0;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    worst = std::max(worst, std::abs(std::log(result.poses[i].metres_per_unit / drive.metres_per_unit[i])));
  }
  return worst;
}

TEST(Rescale, FindsTheMetreOfAPerfectDrive) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit);
  for (const bool drifting : {true, false}) {
    RescaleOptions options = OptionsFor(kCar);
    options.estimator.drifting = drifting;
    const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
    ASSERT_TRUE(result.observable) << result.reason;
    EXPECT_LT(WorstLogError(result, drive), 0.004)
        << "steps of two poses are no single circle where the curvature changes";
    EXPECT_EQ(result.turns.size(), 6u);
    EXPECT_NEAR(result.side_slip, kCar.side_slip, 2e-4);
    EXPECT_NEAR(result.yaw_error, 0, 1e-4);
  }
}

TEST(Rescale, FindsSlipAndYawThatWereGivenWrong) {
  const double yaw = 1.0 / kDegreesPerRadian;
  const ScaledDrive drive = MakeScaledDrive(CityRoute(10), kCar, RotationFromYawPitchRoll({yaw, 0, 0}), kUnit,
                                            {.position = 0.003, .rotation = 0.0002}, 5);
  RescaleOptions options = OptionsFor({kCar.length, 0.0055});
  options.vehicle_from_camera = kIdentity;
  options.estimator.drifting = false;
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_NEAR(result.yaw_error, yaw, 0.001);
  EXPECT_NEAR(result.side_slip, kCar.side_slip, 0.0006);
  EXPECT_LT(WorstLogError(result, drive), 0.03);
}

// The lever arm is seen in proportion to the turning angle, and so is a roll that is none but a pitch of the camera.
TEST(Rescale, PitchOfTheCameraDoesNotBendTheScale) {
  for (const double pitch : {-10.0, 10.0}) {
    const Eigen::Quaterniond mount = RotationFromYawPitchRoll({0, pitch / kDegreesPerRadian, 0});
    const ScaledDrive drive = MakeScaledDrive(CityRoute(9), kCar, mount, kUnit);
    RescaleOptions options = OptionsFor(kCar);
    for (const auto& given : {std::optional(kIdentity), std::optional<Eigen::Quaterniond>()}) {
      options.vehicle_from_camera = given;
      const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
      ASSERT_TRUE(result.observable) << result.reason;
      EXPECT_LT(WorstLogError(result, drive), 0.006) << pitch << (given ? " given as 0" : " to be found");
    }
  }
}

TEST(Rescale, FindsHowTheCameraIsTurned) {
  const YawPitchRoll angles{12 / kDegreesPerRadian, -8 / kDegreesPerRadian, 5 / kDegreesPerRadian};
  Eigen::Matrix3d vehicle_axes;  // x forward, y left, z up
  vehicle_axes << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  for (const auto& mount : {RotationFromYawPitchRoll(angles), Eigen::Quaterniond(vehicle_axes)}) {
    const ScaledDrive drive = MakeScaledDrive(CityRoute(9), kCar, mount, kUnit, {.position = 0.003}, 2);
    RescaleOptions options = OptionsFor(kCar);
    options.estimator.drifting = false;
    const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
    ASSERT_TRUE(result.observable) << result.reason;
    EXPECT_LT(RotationAngle(result.vehicle_from_camera.conjugate() * mount), 1 / kDegreesPerRadian);
    EXPECT_LT(WorstLogError(result, drive), 0.02);
  }
}

TEST(Rescale, SaysWhenTheAxesAreNotACameras) {
  Eigen::Matrix3d vehicle_axes;
  vehicle_axes << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const ScaledDrive drive = MakeScaledDrive(CityRoute(4), kCar, Eigen::Quaterniond(vehicle_axes), kUnit);
  RescaleOptions options = OptionsFor(kCar);
  options.vehicle_from_camera = kIdentity;
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
  EXPECT_FALSE(result.observable);
  EXPECT_NE(result.reason.find("sideways"), std::string::npos) << result.reason;
}

// Of 6 degrees per g, whichever way the camera is pitched.
TEST(Rescale, BodyRollIsNoLeverArm) {
  for (const double pitch : {-8.0, 0.0, 8.0}) {
    const Eigen::Quaterniond mount = RotationFromYawPitchRoll({0, pitch / kDegreesPerRadian, 0});
    const ScaledDrive drive = MakeScaledDrive(CityRoute(12), kCar, mount, kUnit, {.position = 0.002}, 3, {0.8, 0.0107});
    RescaleOptions options = OptionsFor(kCar);
    options.estimator.drifting = false;
    const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
    ASSERT_TRUE(result.observable) << result.reason;
    EXPECT_NEAR(result.height, 0.8, 0.15) << "expected about " << options.car.height << " beforehand";
    EXPECT_LT(WorstLogError(result, drive), 0.006);
    options.car.height = 0;
    options.car.height_sigma = 1e-6;
    EXPECT_GT(WorstLogError(RescaleTrajectory(options, drive.trajectory), drive), 1.5 * WorstLogError(result, drive))
        << "with the roll not asked for";
  }
}

TEST(Rescale, AnyUnitGivesTheSameMetres) {
  const ScaledDrive a = MakeScaledDrive(CityRoute(5), kCar, kIdentity, 1.0, {.position = 0.004}, 3);
  const ScaledDrive b = MakeScaledDrive(CityRoute(5), kCar, kIdentity, 250.0, {.position = 0.004}, 3);
  const RescaleResult in_a = RescaleTrajectory(OptionsFor(kCar), a.trajectory);
  const RescaleResult in_b = RescaleTrajectory(OptionsFor(kCar), b.trajectory);
  ASSERT_TRUE(in_a.observable && in_b.observable);
  EXPECT_NEAR(in_a.length, in_b.length, 1e-6 * in_a.length);
}

TEST(Rescale, FollowsADriftAndSaysHowWell) {
  double inside = 0;
  double count = 0;
  for (const std::uint64_t seed : {11, 12, 13, 14, 15, 16}) {
    const ScaledDrive drive = MakeScaledDrive(CityRoute(16), kCar, kIdentity, kUnit,
                                              {.position = 0.006, .rotation = 0.0003, .drift = 0.002}, seed);
    RescaleOptions options = OptionsFor(kCar);
    options.lever_arm_sigma = 0;  // the tape is exact here
    const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
    ASSERT_TRUE(result.observable) << result.reason;
    const auto [low, high] = std::minmax_element(drive.metres_per_unit.begin(), drive.metres_per_unit.end());
    EXPECT_LT(WorstLogError(result, drive), std::max(0.06, 0.8 * std::log(*high / *low)));
    for (std::size_t i = 0; i < result.poses.size(); ++i) {
      const double error = std::log(result.poses[i].metres_per_unit / drive.metres_per_unit[i]);
      inside += std::abs(error) <= result.poses[i].sigma ? 1 : 0;
      ++count;
    }
  }
  EXPECT_GT(inside / count, 0.55);
  EXPECT_LT(inside / count, 0.9);
}

TEST(Rescale, MetricTrajectoryIsTheDriveInMetres) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit, {.drift = 0.001}, 4);
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  ASSERT_TRUE(result.observable);
  ASSERT_EQ(result.metric.size(), drive.trajectory.size());
  for (std::size_t i = 1; i < result.metric.size(); ++i) {
    const auto step = [&](const Trajectory& t) {
      return (t[i].world_from_camera.translation - t[i - 1].world_from_camera.translation).norm();
    };
    EXPECT_NEAR(step(result.metric) / step(drive.trajectory),
                0.5 * (result.poses[i - 1].metres_per_unit + result.poses[i].metres_per_unit), 1e-9 * kUnit);
    EXPECT_EQ(result.metric[i].time, drive.trajectory[i].time);
  }
}

TEST(Rescale, LiveScaleKnowsOnlyThePast) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit, {.position = 0.004}, 9);
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  ASSERT_TRUE(result.observable);
  const RescaledTurn& first = result.turns.front();
  for (int i = 0; i < first.last_pose; ++i) EXPECT_EQ(result.poses[i].live_metres_per_unit, 0);
  const PoseScale& after = result.poses[first.last_pose + 1];
  EXPECT_NEAR(after.live_metres_per_unit / kUnit, 1, 3 * after.live_sigma);
  EXPECT_GT(after.live_sigma, result.poses.back().sigma);
}

TEST(Rescale, ASkiddingTurnHasLittleSay) {
  std::vector<DriveSegment> route = CityRoute(9);
  ScaledDrive drive = MakeScaledDrive(route, kCar, kIdentity, kUnit, {.position = 0.003}, 8);
  RescaleOptions options = OptionsFor(kCar);
  options.estimator.drifting = false;
  const RescaleResult clean = RescaleTrajectory(options, drive.trajectory);
  // In the fourth turn the rear slides outwards: the camera swings by half a lever arm more than it should.
  const RescaledTurn turn = clean.turns[3];
  const Trajectory before = drive.trajectory;
  Eigen::Vector3d off = Eigen::Vector3d::Zero();
  for (std::size_t i = turn.first_pose + 1; i < drive.trajectory.size(); ++i) {
    RigidTransform& pose = drive.trajectory[i].world_from_camera;
    if (static_cast<int>(i) <= turn.last_pose) {
      const double psi = TwistAboutY(before[i - 1].world_from_camera.rotation.conjugate() * pose.rotation);
      off += pose.rotation * Eigen::Vector3d(0.5 * kCar.length * psi / kUnit, 0, 0);
    }
    pose.translation += off;
  }
  const RescaleResult skid = RescaleTrajectory(options, drive.trajectory);
  ASSERT_TRUE(skid.observable) << skid.reason;
  EXPECT_LT(skid.turns[3].weight, 0.35);
  EXPECT_NEAR(skid.poses[0].metres_per_unit / kUnit, 1, 0.03);
}

TEST(Rescale, KeyframesAtIrregularTimesWillDo) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(8), kCar, kIdentity, kUnit, {.position = 0.003}, 6);
  Trajectory keyframes;
  for (std::size_t i = 0; i < drive.trajectory.size(); i += 1 + (i * 7) % 4) keyframes.push_back(drive.trajectory[i]);
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), keyframes);
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_EQ(result.key_spacing, 1);
  for (const PoseScale& pose : result.poses) EXPECT_NEAR(pose.metres_per_unit / kUnit, 1, 0.04);
}

TEST(Rescale, StandingStillDoesNoHarm) {
  ScaledDrive drive = MakeScaledDrive(CityRoute(5), kCar, kIdentity, kUnit);
  const RescaleResult moving = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  const StampedPose stop = drive.trajectory[30];
  for (std::size_t i = 31; i < drive.trajectory.size(); ++i) drive.trajectory[i].time += 50;
  std::vector<StampedPose> standing(500, stop);
  for (std::size_t i = 0; i < standing.size(); ++i) standing[i].time += 0.1 * static_cast<double>(i + 1);
  drive.trajectory.insert(drive.trajectory.begin() + 31, standing.begin(), standing.end());
  const RescaleResult standing_too = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  ASSERT_TRUE(standing_too.observable) << standing_too.reason;
  EXPECT_NEAR(standing_too.poses.back().metres_per_unit / moving.poses.back().metres_per_unit, 1, 0.003);
}

TEST(Rescale, LostTrackingAndJumpsDoNoHarm) {
  ScaledDrive drive = MakeScaledDrive(CityRoute(8), kCar, kIdentity, kUnit, {.position = 0.003}, 7);
  // Tracking is lost for two seconds on a straight, the last pose repeated; found again, the odometry has jumped.
  const int lost = static_cast<int>(drive.trajectory.size()) / 2;
  for (int i = lost; i < lost + 20; ++i)
    drive.trajectory[i].world_from_camera = drive.trajectory[lost].world_from_camera;
  for (std::size_t i = lost + 20; i < drive.trajectory.size(); ++i) {
    drive.trajectory[i].world_from_camera.translation += Eigen::Vector3d(100, 3, -250) / kUnit;
  }
  RescaleOptions options = OptionsFor(kCar);
  options.estimator.drifting = false;
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_NEAR(result.poses[0].metres_per_unit / kUnit, 1, 0.02);
  EXPECT_NEAR(result.side_slip, kCar.side_slip, 0.001);
}

TEST(Rescale, TyresDoNotSlipInwards) {
  // A car whose lever arm seems to grow with speed.
  const ScaledDrive drive = MakeScaledDrive(CityRoute(10), {1.2, -0.01}, kIdentity, kUnit, {.position = 0.002}, 7);
  const RescaleResult result = RescaleTrajectory(OptionsFor({1.2, 0.001}), drive.trajectory);
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_GE(result.side_slip, 0);
  EXPECT_LT(result.side_slip, 1e-6);
}

TEST(Rescale, WithoutTimesTheTyresDoNotSlip) {
  const LeverArm rigid{1.2, 0};
  ScaledDrive drive = MakeScaledDrive(CityRoute(5), rigid, kIdentity, kUnit);
  for (StampedPose& pose : drive.trajectory) pose.time = 0;
  RescaleOptions options = OptionsFor({rigid.length, 0.0045});
  EXPECT_THROW(RescaleTrajectory(options, drive.trajectory), InputError);
  options.timed = false;
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_LT(WorstLogError(result, drive), 0.004);
  EXPECT_EQ(result.side_slip_sigma, 0);
}

TEST(Rescale, InventsNothingWithoutATurn) {
  for (const double bend : {0.0, 1e-4}) {
    const ScaledDrive drive =
        MakeScaledDrive({{400, 1.0, bend}}, kCar, kIdentity, kUnit, {.position = 0.003, .rotation = 0.0002});
    const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
    EXPECT_FALSE(result.observable);
    EXPECT_FALSE(result.reason.empty());
    EXPECT_TRUE(result.metric.empty() && result.poses.empty());
  }
}

TEST(Rescale, InventsNothingFromTurnsThatAreTooFast) {
  // At 20 m/s the slip of 0.004 s^2/m exceeds the lever arm.
  const ScaledDrive drive =
      MakeScaledDrive({{100, 2.0, 0}, {60, 2.0, 0.02}, {100, 2.0, 0}}, kCar, kIdentity, kUnit, {.position = 0.003});
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  EXPECT_FALSE(result.observable);
  EXPECT_NE(result.reason.find("slow enough"), std::string::npos) << result.reason;
}

TEST(Rescale, RefusesSenselessInput) {
  const RescaleOptions options = OptionsFor(kCar);
  EXPECT_THROW(RescaleTrajectory(options, {}), InputError);
  ScaledDrive drive = MakeScaledDrive(CityRoute(2), kCar, kIdentity, kUnit);
  drive.trajectory[7].world_from_camera.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(RescaleTrajectory(options, drive.trajectory), InputError);
}

TEST(Rescale, ChecksItsOptions) {
  const auto refused = [](auto change) {
    return RefusedField<RescaleOptions>([&](RescaleOptions& options) {
      options.car.lever_arm = 1;
      change(options);
    });
  };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.car.lever_arm = 0; }), "car.lever_arm");
  EXPECT_EQ(refused([](auto& o) { o.car.side_slip = -1; }), "car.side_slip");
  EXPECT_EQ(refused([](auto& o) { o.car.yaw_sigma = 0; }), "car.yaw_sigma");
  EXPECT_EQ(refused([](auto& o) { o.keys.max_spacing = 0; }), "keys.max_spacing");
  EXPECT_EQ(refused([](auto& o) { o.stretches.max_straight_steps = 0; }), "stretches.max_straight_steps");
  EXPECT_EQ(refused([](auto& o) { o.estimator.huber = 0; }), "estimator.huber");
  EXPECT_EQ(refused([](auto& o) { o.estimator.noise.lever.low = 0; }), "noise.lever");
  EXPECT_EQ(refused([](auto& o) { o.estimator.noise.per_angle.typical = 1; }), "noise.per_angle");
  EXPECT_EQ(refused([](auto& o) { o.lever_arm_sigma = -1; }), "lever_arm_sigma");
}

}  // namespace
}  // namespace turnscale
