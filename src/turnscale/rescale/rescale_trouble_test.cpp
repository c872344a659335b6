// SPDX-License-Identifier: MIT
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/rescale/test_rescale_drive.h"

namespace turnscale {
namespace {

// The drive with its fourth turn skidding: there the rear slides outwards, and the camera swings by this part of the
// lever arm more than it should.
Trajectory WithASkid(const ScaledDrive& drive, const PosesOfTurn& turn, double part) {
  Trajectory skid = drive.trajectory;
  Eigen::Vector3d off = Eigen::Vector3d::Zero();
  for (std::size_t i = turn.first + 1; i < skid.size(); ++i) {
    RigidTransform& pose = skid[i].world_from_camera;
    if (static_cast<int>(i) <= turn.last) {
      const double psi = TwistAboutY(drive.trajectory[i - 1].world_from_camera.rotation.conjugate() * pose.rotation);
      off += pose.rotation * Eigen::Vector3d(part * kCar.length * psi / kUnit, 0, 0);
    }
    pose.translation += off;
  }
  return skid;
}

TEST(Rescale, ASkiddingTurnHasLittleSay) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(9), kCar, kIdentity, kUnit, {.position = 0.003}, 8);
  RescaleOptions options = OptionsFor(kCar);
  options.drifting = false;
  const PosesOfTurn turn = PosesOf(RescaleTrajectory(options, drive.trajectory), 3);
  const RescaleResult skid = RescaleTrajectory(options, WithASkid(drive, turn, 0.2));
  ASSERT_TRUE(skid.observable) << skid.reason;
  EXPECT_LT(skid.estimate->turns[3].weight, 0.35);
  EXPECT_FALSE(skid.estimate->uses_single_turns);
  EXPECT_NEAR(skid.poses[0].metres_per_unit / kUnit, 1, 0.03);
}

// No one scale agrees with a turn that skids by half of the lever arm.
TEST(Rescale, ATurnThatContradictsTheOthersIsNamed) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(9), kCar, kIdentity, kUnit, {.position = 0.003}, 8);
  RescaleOptions options = OptionsFor(kCar);
  options.drifting = false;
  options.estimator.max_sigma = 1;
  const PosesOfTurn turn = PosesOf(RescaleTrajectory(options, drive.trajectory), 3);
  const RescaleResult skid = RescaleTrajectory(options, WithASkid(drive, turn, 0.5));
  ASSERT_TRUE(skid.observable) << skid.reason;
  EXPECT_TRUE(skid.estimate->test.contradicted);
  EXPECT_TRUE(skid.estimate->uses_single_turns);
  EXPECT_EQ(skid.estimate->test.worst_turn, 3);
  EXPECT_NEAR(skid.poses[0].metres_per_unit / kUnit, 1, 0.008) << "far from it the other turns are used singly";
  for (const RescaledPose& pose : skid.poses)
    EXPECT_LT(std::abs(std::log(pose.metres_per_unit / kUnit)), 2 * pose.sigma);
}

TEST(Rescale, KeyframesAtIrregularTimesWillDo) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(8), kCar, kIdentity, kUnit, {.position = 0.003}, 6);
  Trajectory keyframes;
  for (std::size_t i = 0; i < drive.trajectory.size(); i += 1 + (i * 7) % 4) keyframes.push_back(drive.trajectory[i]);
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), keyframes);
  ASSERT_TRUE(result.observable) << result.reason;
  for (const RescaledPose& pose : result.poses) EXPECT_NEAR(pose.metres_per_unit / kUnit, 1, 0.011);
}

// Half of each turn is missing: as one step, it would have most of the say.
TEST(Rescale, HolesInTurnsShowNoScale) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit, {.position = 0.003}, 6);
  const RescaleOptions options = OptionsFor(kCar);
  const RescaleResult whole = RescaleTrajectory(options, drive.trajectory);
  ASSERT_TRUE(whole.observable) << whole.reason;
  Trajectory sparse = drive.trajectory;
  for (int turn = static_cast<int>(whole.estimate->turns.size()) - 1; turn >= 0; --turn) {
    const PosesOfTurn poses = PosesOf(whole, turn);
    const int quarter = (poses.last - poses.first) / 4;
    sparse.erase(sparse.begin() + poses.first + quarter, sparse.begin() + poses.last - quarter);
  }
  const RescaleResult result = RescaleTrajectory(options, sparse);
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_GE(std::ranges::count_if(result.steps, [](const VehicleStep& step) { return !step.dense; }), 4);
  for (const RescaledPose& pose : result.poses) EXPECT_LT(std::abs(std::log(pose.metres_per_unit / kUnit)), 0.03);
  // Nothing but holes.
  Trajectory rare;
  for (std::size_t i = 0; i < drive.trajectory.size(); i += 15) rare.push_back(drive.trajectory[i]);
  const RescaleResult none = RescaleTrajectory(options, rare);
  EXPECT_FALSE(none.observable);
  EXPECT_NE(none.reason.find("far apart"), std::string::npos) << none.reason;
}

TEST(Rescale, SparsePosesAreNamedAsTheReason) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit, {.position = 0.003}, 6);
  const double interval = drive.trajectory[1].time - drive.trajectory[0].time;
  RescaleOptions options = OptionsFor(kCar);
  for (const double seconds : {2.0, 3.0, 5.0}) {
    Trajectory rare;
    const auto every = static_cast<std::size_t>(std::lround(seconds / interval));
    for (std::size_t i = 0; i < drive.trajectory.size(); i += every) rare.push_back(drive.trajectory[i]);
    options.timed = true;
    EXPECT_EQ(RescaleTrajectory(options, rare).reason, "in turns the poses are too far apart (median interval " +
                                                           NumberText(seconds) + " s); give the poses of more frames");
    options.timed = false;
    EXPECT_EQ(RescaleTrajectory(options, rare).reason,
              "in turns the poses are too far apart; give the poses of more frames");
  }
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
  EXPECT_NEAR(standing_too.poses.back().metres_per_unit / moving.poses.back().metres_per_unit, 1, 0.0002);
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
  options.drifting = false;
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_NEAR(result.poses[0].metres_per_unit / kUnit, 1, 0.001);
  EXPECT_NEAR(result.estimate->car.side_slip, kCar.side_slip, 0.0004);
  double driven = 0;
  for (std::size_t i = 1; i < drive.trajectory.size(); ++i) {
    const auto& place = [&](std::size_t k) { return drive.trajectory[k].world_from_camera.translation; };
    if (static_cast<int>(i) != lost + 20) driven += kUnit * (place(i) - place(i - 1)).norm();
  }
  EXPECT_NEAR(result.length / driven, 1, 0.008) << "the jump is no way driven";
}

TEST(Rescale, TheScaleMayJumpAcrossAGapThatIsNamed) {
  ScaledDrive drive = MakeScaledDrive(CityRoute(10), kCar, kIdentity, kUnit, {.position = 0.003}, 7);
  const std::size_t gap = drive.trajectory.size() / 2;
  const Eigen::Vector3d anew(3, -2, 1);
  for (std::size_t i = gap; i < drive.trajectory.size(); ++i) {
    Eigen::Vector3d& place = drive.trajectory[i].world_from_camera.translation;
    place = anew + 0.8 * place;
    drive.metres_per_unit[i] /= 0.8;
  }
  RescaleOptions options = OptionsFor(kCar);
  options.drifting = false;
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory, {{static_cast<int>(gap), 0.3}});
  ASSERT_TRUE(result.observable) << result.reason;
  EXPECT_LT(WorstLogError(result, drive), 0.0045) << "up to the very pose of the gap";
  for (const int bad : {0, -3, static_cast<int>(drive.trajectory.size())}) {
    EXPECT_THROW(RescaleTrajectory(options, drive.trajectory, {{bad, 0.3}}), InputError);
  }
  EXPECT_THROW(RescaleTrajectory(options, drive.trajectory, {{9, 0.3}, {9, 0.3}}), InputError);
  EXPECT_THROW(RescaleTrajectory(options, drive.trajectory, {{9, 0}}), InputError);
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
  EXPECT_NE(result.reason.find("slow"), std::string::npos) << result.reason;
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
  EXPECT_EQ(refused([](auto& o) { o.car.lever_arm_sigma = -1; }), "car.lever_arm_sigma");
  EXPECT_EQ(refused([](auto& o) { o.steps.max_poses = 0; }), "steps.max_poses");
  EXPECT_EQ(refused([](auto& o) { o.estimator.segments.max_straight_steps = 0; }), "estimator.max_straight_steps");
  EXPECT_EQ(refused([](auto& o) { o.estimator.evidence.turn_sigma = 0; }), "estimator.evidence.turn_sigma");
  EXPECT_EQ(refused([](auto& o) { o.estimator.drift.per_90deg = 1; }), "estimator.drift.per_90deg");
  EXPECT_EQ(refused([](auto& o) { o.estimator.huber = 0; }), "estimator.huber");
}

}  // namespace
}  // namespace turnscale
