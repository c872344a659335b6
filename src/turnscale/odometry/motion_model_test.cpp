// SPDX-License-Identifier: MIT
#include "turnscale/odometry/motion_model.h"

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

const RigidTransform kStep{RotationFromVector({0.01, -0.06, 0.002}), {0.1, -0.02, -0.9}};
const RigidTransform kStart{RotationFromVector({0.2, 0.4, -0.1}), {3, 1, -7}};

void ExpectNear(const RigidTransform& a, const RigidTransform& b) {
  EXPECT_LT(RotationAngle(a.rotation * b.rotation.conjugate()), 1e-12);
  EXPECT_LT((a.translation - b.translation).norm(), 1e-12);
}

TEST(MotionModel, StandsStillUntilItKnowsTwoPoses) {
  MotionModel motion;
  ExpectNear(motion.Predict(5), RigidTransform{});
  motion.Update(1, kStart);
  ExpectNear(motion.Predict(5), kStart);
  EXPECT_EQ(motion.speed(), 0);
}

TEST(MotionModel, GoesOnAsItMovedLast) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  ExpectNear(motion.Predict(1.1), kStep * kStart);
  ExpectNear(motion.Predict(1.2), kStep * kStep * kStart);
  EXPECT_NEAR(motion.speed(), kStep.translation.norm() / 0.1, 1e-9);
  const RigidTransform half = motion.Predict(1.15) * motion.last().inverse();
  EXPECT_NEAR(RotationAngle(half.rotation), 0.5 * RotationAngle(kStep.rotation), 1e-12);
  EXPECT_LT((half.translation - 0.5 * kStep.translation).norm(), 1e-12);
}

TEST(MotionModel, TheLastStepCounts) {
  MotionModel motion;
  motion.Update(0.0, kStart);
  motion.Update(0.1, kStep * kStart);
  motion.Update(0.3, kStep * kStep * kStart);
  const RigidTransform half = motion.Predict(0.4) * motion.last().inverse();
  EXPECT_NEAR(RotationAngle(half.rotation), 0.5 * RotationAngle(kStep.rotation), 1e-12) << "0.1 s of a step of 0.2 s";
  EXPECT_NEAR(motion.speed(), kStep.translation.norm() / 0.2, 1e-9);
}

TEST(MotionModel, TimeThatStandsStillGivesNoVelocity) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.0, kStep * kStart);
  EXPECT_EQ(motion.speed(), 0);
  ExpectNear(motion.Predict(2.0), kStep * kStart);
}

TEST(MotionModel, ACorrectionMovesThePoseAndScalesTheSpeed) {
  MotionModel motion;
  motion.Update(1.0, kStart);
  motion.Update(1.1, kStep * kStart);
  const RigidTransform corrected{RotationFromVector({0, 0.1, 0}), {1, 2, 3}};
  const double speed = motion.speed();
  motion.Correct(corrected, 7.0);
  EXPECT_NEAR(motion.speed(), 7 * speed, 1e-9);
  const RigidTransform longer{kStep.rotation, 7 * kStep.translation};
  ExpectNear(motion.Predict(1.2), longer * corrected);
}

}  // namespace
}  // namespace turnscale
