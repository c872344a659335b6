// SPDX-License-Identifier: MIT
#include "turnscale/calibration/step_residual.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

Eigen::Vector3d RandomVector(Random& random) {
  const double x = random.Gaussian();
  const double y = random.Gaussian();
  const double z = random.Gaussian();
  return {x, y, z};
}

TEST(StepResidual, VanishesOnTheModel) {
  for (const double psi : {-0.3, -1e-4, 0.0, 0.05, 0.4}) {
    const AckermannStep step{psi, 0.9};
    const RigidTransform motion = ConstrainedCameraMotion(step, 1.3, kTiltedDown);
    const double length = motion.translation.norm();
    const StepMeasurement measured{motion.rotation, motion.translation / length, length};
    EXPECT_LT(EvaluateStep(measured, kTiltedDown, psi, 1.3 / length).value.norm(), 1e-14);
    EXPECT_NEAR(TravelDirection(psi, 1.3 / length), DirectionOfTravel(step, 1.3), 1e-14);
  }
}

TEST(StepResidual, FirstHalfIsTheFrobeniusNormOf15) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const StepMeasurement step{RotationFromVector(0.3 * RandomVector(random)), RandomVector(random).normalized(), 1};
    const double psi = random.Uniform(-0.5, 0.5);
    const Eigen::Matrix3d difference =
        step.rotation.toRotationMatrix() -
        (kTiltedDown.conjugate() * RotationFromVector({0, psi, 0}) * kTiltedDown).toRotationMatrix();
    EXPECT_NEAR(EvaluateStep(step, kTiltedDown, psi, 1).value.head<3>().norm(), difference.norm(), 1e-12);
  }
}

TEST(StepResidual, JacobiansAreThoseOfDifferences) {
  constexpr double kStep = 1e-6;
  Random random(7);
  for (int i = 0; i < 20; ++i) {
    const StepMeasurement step{RotationFromVector(0.2 * RandomVector(random)), RandomVector(random).normalized(), 1};
    const Eigen::Quaterniond rotation = RotationFromVector(RandomVector(random));
    const double psi = random.Uniform(-0.5, 0.5);
    const double lever_ratio = random.Uniform(0, 1.5);
    const StepResidual at = EvaluateStep(step, rotation, psi, lever_ratio);
    const auto slope = [&](const Eigen::Vector3d& turn, double by_psi, double by_ratio) {
      const auto value = [&](double sign) {
        return EvaluateStep(step, RotationFromVector(sign * kStep * turn) * rotation, psi + sign * kStep * by_psi,
                            lever_ratio + sign * kStep * by_ratio)
            .value;
      };
      return StepResidual::Vector((value(1) - value(-1)) / (2 * kStep));
    };
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LT((slope(Eigen::Vector3d::Unit(axis), 0, 0) - at.by_rotation.col(axis)).norm(), 1e-8);
    }
    EXPECT_LT((slope(Eigen::Vector3d::Zero(), 1, 0) - at.by_psi).norm(), 1e-8);
    EXPECT_LT((slope(Eigen::Vector3d::Zero(), 0, 1) - at.by_ratio).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace turnscale
