// SPDX-License-Identifier: MIT
#include "turnscale/calibration/linear_calibration.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

LinearSolution Solve(const std::vector<int>& turns, double lever_arm) {
  LinearCalibration linear;
  for (const DriveSegment& segment : TestRoute(turns)) {
    const RigidTransform motion = SlippingCameraMotion(segment, 0.1, {lever_arm, 0}, kTiltedDown);
    for (int i = 0; i < segment.steps; ++i) linear.Add(motion, segment.psi);
  }
  return linear.Solve();
}

TEST(LinearCalibration, IsExactWithoutALeverArm) {
  const LinearSolution solution = Solve({1}, 0);
  EXPECT_LT(DegreesBetween(solution.vehicle_from_camera, kTiltedDown), 1e-9);
  EXPECT_GT(solution.confidence, 5e5);
}

TEST(LinearCalibration, TheLeverArmBendsItAsThePaperSays) {
  const YawPitchRoll found = YawPitchRollFromRotation(Solve({1}, 1).vehicle_from_camera);
  EXPECT_GT(std::abs(found.yaw - 0.2) * kDegreesPerRadian, 0.2);
}

TEST(LinearCalibration, AStraightDriveIsNotUnique) {
  const LinearSolution solution = Solve({}, 1);
  EXPECT_LT(solution.singular_values[1], 1e-6);
  EXPECT_LT(solution.confidence, 1.1);
}

TEST(TurningAxis, SignsTheWholeDriveByOneAxis) {
  TurningAxis axis;
  for (const double psi : {0.04, -0.05, 0.001, 0.03, -0.02}) {
    axis.Add(ConstrainedCameraMotion({psi, 1}, 1, kTiltedDown).rotation);
  }
  EXPECT_LT((axis.direction() - kTiltedDown.conjugate() * Eigen::Vector3d::UnitY()).norm(), 1e-9);
  for (const double psi : {0.4, -1e-7, 1e-9}) {
    const Eigen::Quaterniond rotation = ConstrainedCameraMotion({psi, 1}, 1, kTiltedDown).rotation;
    EXPECT_NEAR(TurningAngle(rotation, axis.direction()) / psi, 1, 1e-6);
  }
}

}  // namespace
}  // namespace turnscale
