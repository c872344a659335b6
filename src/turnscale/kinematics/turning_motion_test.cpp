// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/turning_motion.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kTilted = RotationFromYawPitchRoll({0.2, -0.3, 0.1});

TEST(TurningMotion, ReadsTheConstrainedMotionBack) {
  for (const double psi : {-0.4, -0.01, 0.0, 1e-9, 0.05, 0.8}) {
    const AckermannStep step{psi, 0.7};
    const TurningMotion motion = TurningMotionOf(ConstrainedCameraMotion(step, 1.3, kTilted), kTilted);
    EXPECT_NEAR(motion.psi, psi, 1e-15 + 1e-14 * std::abs(psi));
    EXPECT_NEAR(motion.theta, DirectionOfTravel(step, 1.3), 1e-14);
    EXPECT_NEAR(motion.step, CameraDistance(step, 1.3), 1e-14);
  }
}

TEST(TurningMotion, TinyTurnsKeepTheirDigitsAndSign) {
  for (const double psi : {1e-10, -1e-10}) {
    const RigidTransform motion = ConstrainedCameraMotion({psi, 0.7}, 1.3, Eigen::Quaterniond::Identity());
    EXPECT_NEAR(TurningMotionOf(motion, Eigen::Quaterniond::Identity()).psi / psi, 1.0, 1e-6);
    const double by_trace = std::acos(std::min(1.0, 0.5 * (motion.rotation.toRotationMatrix().trace() - 1.0)));
    EXPECT_GT(std::abs(by_trace / psi - 1.0), 0.5) << "(9) as printed has lost the turn";
  }
}

TEST(TurningMotion, PitchingAndRollingAreNotTurning) {
  const RigidTransform bump{RotationFromVector({0.02, 0.05, -0.01}), {0, 0, 1}};
  EXPECT_NEAR(TurningMotionOf(bump, Eigen::Quaterniond::Identity()).psi, 0.05, 5e-6);
  EXPECT_GT(RotationAngle(bump.rotation), 0.0545);
}

TEST(TurningMotion, StandstillHasNoDirection) {
  const TurningMotion motion = TurningMotionOf(RigidTransform{}, kTilted);
  EXPECT_EQ(motion.psi, 0);
  EXPECT_EQ(motion.theta, 0);
  EXPECT_EQ(motion.step, 0);
}

}  // namespace
}  // namespace turnscale
