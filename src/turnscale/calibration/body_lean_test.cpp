// SPDX-License-Identifier: MIT
#include "turnscale/calibration/body_lean.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

constexpr double kPerAcceleration = -0.4 * kDeg;  // rad over m/s^2: outwards, 4 deg per g

// The same drive with a body on springs: its lean follows the sideways acceleration with a little delay.
Trajectory Leaning(const std::vector<int>& turns, double noise, int seed, double per_acceleration = kPerAcceleration) {
  const auto route = TestRoute(turns);
  const Trajectory rigid = TestPath(route, {1, 0}, Eigen::Quaterniond::Identity(), noise, seed);
  Trajectory path{rigid.front()};
  double lean = 0;
  size_t i = 1;
  for (const DriveSegment& segment : route) {
    for (int k = 0; k < segment.steps; ++k, ++i) {
      const double acceleration = (segment.camera_distance / 0.1) * (segment.psi / 0.1);
      lean += 0.5 * (per_acceleration * acceleration - lean);
      StampedPose pose = rigid[i];
      pose.world_from_camera.rotation = pose.world_from_camera.rotation * RotationFromVector({0, 0, lean}) * kTilted;
      path.push_back(pose);
    }
  }
  path.front().world_from_camera.rotation = kTilted;
  return path;
}

TEST(BodyLean, IsReadFromTheRollAtBothEndsOfATurn) {
  const auto steps = StepsAlong(Leaning({1, -1, 1}, 0.05 * kDeg, 3));
  const BodyLean lean = FitBodyLean(steps, kTilted);
  EXPECT_NEAR(lean.per_acceleration, kPerAcceleration, 0.1 * std::abs(kPerAcceleration));
  EXPECT_NEAR(lean.per_acceleration, kPerAcceleration, lean.sigma);
  EXPECT_LT(lean.sigma, 0.1 * std::abs(kPerAcceleration));
}

TEST(BodyLean, DoesNotPassForARollOfTheCamera) {
  const auto steps = StepsAlong(Leaning({-1, -1}, 0.05 * kDeg, 3));
  CalibrationOptions rigid;
  rigid.body_lean = false;
  const double wanted = YawPitchRollFromRotation(kTilted).roll;
  // 4.2 m/s^2 to the left.
  EXPECT_GT(std::abs(Calibrate(steps, rigid).angles.roll - wanted), 1.2 * kDeg);
  EXPECT_NEAR(Calibrate(steps).angles.roll, wanted, 0.02 * kDeg);
}

TEST(BodyLean, ARigidBodyShowsNone) {
  const auto steps = StepsAlong(TestPath(TestRoute({1, 1}), {1, 0}, kTilted));
  const BodyLean lean = FitBodyLean(steps, kTilted);
  EXPECT_NEAR(lean.per_acceleration, 0, 1e-3 * std::abs(kPerAcceleration));
  EXPECT_GT(lean.mean_acceleration, 3);
}

TEST(BodyLean, NoBodyLeansInwards) {
  EXPECT_EQ(FitBodyLean(StepsAlong(Leaning({1, -1}, 0, 3, -kPerAcceleration)), kTilted).per_acceleration, 0);
}

TEST(BodyLean, LevelledUndoesIt) {
  const auto steps = StepsAlong(TestPath(TestRoute({1}), {1, 0}, kTilted));
  BodyLean lean;
  EXPECT_LT(DegreesBetween(Levelled(steps, kTilted, lean)[12].previous_from_current.rotation,
                           steps[12].previous_from_current.rotation),
            1e-12);
  lean.per_acceleration = kPerAcceleration;
  const auto levelled = Levelled(steps, kTilted, lean);
  const Eigen::Vector3d before = kTilted * VectorFromRotation(steps[12].previous_from_current.rotation);
  const Eigen::Vector3d after = kTilted * VectorFromRotation(levelled[12].previous_from_current.rotation);
  // To the right, a body that leans left by phi sees the axis tilted the other way.
  EXPECT_NEAR(after.x(), before.x() + before.y() * std::sin(-kPerAcceleration * 8 * 10 * 3 * kDeg), 1e-9);
}

TEST(BodyLean, TooFewStepsTellNothing) {
  EXPECT_EQ(FitBodyLean({}, kTilted).per_acceleration, 0);
  const auto few = StepsAlong(TestPath({{40, 0.8, 2 * kDeg}}, {1, 0}, kTilted));
  EXPECT_EQ(FitBodyLean(few, kTilted).sigma, 0);
}

}  // namespace
}  // namespace turnscale
