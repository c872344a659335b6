// SPDX-License-Identifier: MIT
#include "turnscale/calibration/online_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/base/test_seeds.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

const std::vector<int> kTurns{1, -1, 1, 1, -1, -1, 1, -1};

std::vector<CameraStep> Steps(const Eigen::Quaterniond& rotation, int seed) {
  return StepsAlong(TestPath(TestRoute(kTurns), {1.2, 0}, rotation, 0.2 * kDeg, seed));
}

TEST(OnlineCalibration, WaitsForTheFirstTurnAndThenHolds) {
  OnlineCalibration online;
  double usable_from = 1e9;
  for (const CameraStep& step : Steps(kTilted, 1)) {
    const OnlineState& state = online.Add(step);
    EXPECT_TRUE(step.end > 6 || !state.estimated);
    EXPECT_TRUE(!state.usable || std::abs(state.angles.yaw - 5 * kDeg) < std::max(0.25 * kDeg, 2 * state.sigma.yaw))
        << step.end;
    if (state.usable) usable_from = std::min(usable_from, step.end);
  }
  // The first turn ends at 9.6 s.
  EXPECT_GT(usable_from, 6);
  EXPECT_LT(usable_from, 13);
  EXPECT_EQ(online.state().moves, 0);
  EXPECT_LT(DegreesBetween(online.state().vehicle_from_camera, kTilted), 0.06);
}

TEST(OnlineCalibration, KnowsNothingBeforeTheFirstTurn) {
  OnlineCalibration online;
  const OnlineState& state = online.Add(Steps(kTilted, 1).front());
  EXPECT_FALSE(state.estimated);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      EXPECT_EQ(state.covariance(row, column), row == column ? std::numeric_limits<double>::infinity() : 0);
    }
  }
  for (const double sigma : {state.sigma.yaw, state.sigma.pitch, state.sigma.roll}) EXPECT_TRUE(std::isinf(sigma));
}

TEST(OnlineCalibration, AgreesWithAllStepsTogether) {
  const auto steps = Steps(kTilted, 2);
  OnlineCalibration online;
  for (const CameraStep& step : steps) online.Add(step);
  const Calibration together = Calibrate(steps);
  EXPECT_NEAR(online.state().angles.yaw, together.angles.yaw, 0.01 * kDeg);
  EXPECT_NEAR(online.state().angles.pitch, together.angles.pitch, 0.03 * kDeg);
}

TEST(OnlineCalibration, NoticesAMovedCameraWithinThirtySeconds) {
  for (const YawPitchRoll& move : {YawPitchRoll{2 * kDeg, 0, 0}, YawPitchRoll{0, -2 * kDeg, 0}}) {
    const Eigen::Quaterniond moved = kTilted * RotationFromYawPitchRoll(move);
    const auto before = Steps(kTilted, 3);
    const auto after = Steps(moved, 4);
    OnlineCalibration online;
    for (const CameraStep& step : before) online.Add(step);
    ASSERT_EQ(online.state().moves, 0);
    double noticed = 1e9;
    for (const CameraStep& step : after) {
      if (online.Add(step).moved) noticed = std::min(noticed, step.end);
    }
    EXPECT_LT(noticed, 16);
    EXPECT_EQ(online.state().moves, 1);
    EXPECT_LT(std::abs(online.state().move_time - after.front().begin), 2) << "begins where the camera was moved";
    EXPECT_TRUE(online.state().usable);
    EXPECT_NEAR(online.state().angles.yaw, YawPitchRollFromRotation(moved).yaw, 0.01 * kDeg);
    EXPECT_NEAR(online.state().angles.pitch, YawPitchRollFromRotation(moved).pitch, 0.05 * kDeg);
  }
}

TEST(OnlineCalibration, NoticesACameraThatIsMovedEarlyInTheDrive) {
  constexpr double kMoved = 25;  // s
  const Eigen::Quaterniond moved = kTilted * RotationFromYawPitchRoll({0, -3 * kDeg, 0});
  const auto before = Steps(kTilted, 3);
  const auto after = Steps(moved, 3);
  ASSERT_EQ(before.size(), after.size());
  OnlineCalibration online;
  double noticed = 1e9;
  for (size_t i = 0; i < after.size(); ++i) {
    if (online.Add(before[i].end < kMoved ? before[i] : after[i]).moved) noticed = std::min(noticed, after[i].end);
  }
  EXPECT_GT(noticed, kMoved);
  EXPECT_LT(noticed, kMoved + 12);
  EXPECT_EQ(online.state().moves, 1);
  EXPECT_NEAR(online.state().move_time, kMoved, 2);
  const Eigen::Vector3d change = VectorFromRotation(moved * kTilted.conjugate());
  EXPECT_NEAR(online.state().move.pitch, change.x(), 0.3 * kDeg);
  EXPECT_NEAR(online.state().move.yaw, change.y(), 0.3 * kDeg);
  EXPECT_NEAR(online.state().angles.pitch, YawPitchRollFromRotation(moved).pitch, 0.05 * kDeg);
}

// A street with a turn at each end: most steps are straight, and what turns there is the body's pitch on bumps.
std::vector<CameraStep> PitchingSteps(int seed, int first_straight = 40) {
  std::vector<DriveSegment> route = {{first_straight, 0.8, 0}};
  for (const int side : {-1, 1, 1}) {
    route.push_back({20, 0.4, side * 4.5 * kDeg});
    route.push_back({260, 0.9, 0});
  }
  Trajectory path = TestPath(route, {1.5, 0}, Eigen::Quaterniond::Identity(), 0.03 * kDeg, seed);
  Random random(static_cast<std::uint64_t>(100 + seed));
  for (StampedPose& pose : path) {
    pose.world_from_camera.rotation =
        pose.world_from_camera.rotation * RotationFromVector({0.4 * kDeg * random.Gaussian(), 0, 0});
  }
  return StepsAlong(EveryFew(path));
}

TEST(OnlineCalibration, PitchingIsNotTakenForTurning) {
  for (int seed = 1; seed <= SeedsToTest(10); ++seed) {
    OnlineCalibration online;
    double largest_roll = 0;
    for (const CameraStep& step : PitchingSteps(seed)) {
      const OnlineState& state = online.Add(step);
      if (state.usable) largest_roll = std::max(largest_roll, std::abs(state.angles.roll));
    }
    EXPECT_TRUE(online.state().usable) << seed;
    EXPECT_LT(largest_roll, 10 * kDeg) << seed;
    EXPECT_LT(std::abs(online.state().angles.yaw), 0.5 * kDeg) << seed;
  }
}

TEST(OnlineCalibration, PitchingBeforeALateFirstTurnIsNotTakenForAMovedCamera) {
  for (int seed = 1; seed <= SeedsToTest(10); ++seed) {
    OnlineCalibration online;
    for (const CameraStep& step : PitchingSteps(seed, 320)) online.Add(step);
    EXPECT_EQ(online.state().moves, 0) << seed;
    EXPECT_LT(std::abs(online.state().angles.yaw), 0.5 * kDeg) << seed;
  }
}

// A move that only the long memory shows.
TEST(OnlineCalibration, ASmallMoveIsReportedOnce) {
  for (int seed = 1; seed <= SeedsToTest(4); ++seed) {
    for (const double degrees : {1.35, 1.5, 1.7}) {
      const Eigen::Quaterniond moved = kTilted * RotationFromYawPitchRoll({0, -degrees * kDeg, 0});
      const auto before = Steps(kTilted, seed);
      const auto after = Steps(moved, seed + 10);
      OnlineCalibration online;
      for (const CameraStep& step : before) online.Add(step);
      for (const CameraStep& step : after) online.Add(step);
      EXPECT_LE(online.state().moves, 1) << seed << ' ' << degrees;
    }
  }
}

// A corner, then a motorway in wide bends of even curvature. Errors of an odometry's rotation and of its direction of
// travel go together, by the depth of the scene: in such a bend they look like a lever arm of that length, and the
// yaw like what is left.
std::vector<CameraStep> MotorwaySteps(int seed) {
  constexpr double kPerFrame = 2.8;  // metres: 28 m/s
  constexpr double kDepth = 40;      // metres
  std::vector<DriveSegment> route = TestRoute({1}, 100);
  route.push_back({300, kPerFrame, 0});
  for (const double radius : {1300.0, -600.0, 2000.0, -1300.0}) {
    route.push_back({400, kPerFrame, kPerFrame / radius});
    route.push_back({100, kPerFrame, 0});
  }
  const Trajectory path = TestPath(route, {0.945, 0.0053}, Eigen::Quaterniond::Identity(), 0.02 * kDeg, seed);
  Random random(static_cast<std::uint64_t>(200 + seed));
  Trajectory disturbed{path.front()};
  for (size_t i = 1; i < path.size(); ++i) {
    RigidTransform motion = path[i - 1].world_from_camera.inverse() * path[i].world_from_camera;
    const double error = 0.005 * kDeg * random.Gaussian();
    motion.rotation = motion.rotation * RotationFromVector({0, error, 0});
    motion.translation = RotationFromVector({0, kDepth / kPerFrame * error, 0}) * motion.translation;
    disturbed.push_back({path[i].time, disturbed.back().world_from_camera * motion});
  }
  return StepsAlong(disturbed);
}

TEST(OnlineCalibration, ALongBendIsNotTakenForAMovedCamera) {
  for (int seed = 1; seed <= SeedsToTest(4); ++seed) {
    OnlineCalibration online;
    for (const CameraStep& step : MotorwaySteps(seed)) online.Add(step);
    EXPECT_EQ(online.state().moves, 0) << seed;
    EXPECT_LT(std::abs(online.state().angles.yaw), 0.3 * kDeg) << seed;
  }
}

TEST(OnlineCalibrationOptions, RefuseSenselessValues) {
  using Options = OnlineCalibrationOptions;
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.window = 10; }), "window");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.drift = -1; }), "drift");
}

}  // namespace
}  // namespace turnscale
