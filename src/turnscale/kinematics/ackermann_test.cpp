// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/ackermann.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/synthetic_drive.h"

namespace turnscale {
namespace {

struct RandomStep {
  AckermannStep step;
  double lever_arm = 0;
  Eigen::Quaterniond vehicle_from_camera;
};

RandomStep Draw(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  RandomStep drawn;
  drawn.step = {0.5 * uniform(random), 0.1 + std::abs(uniform(random))};
  drawn.lever_arm = 1.5 + uniform(random);
  drawn.vehicle_from_camera = RotationFromVector({uniform(random), uniform(random), uniform(random)});
  return drawn;
}

/// The rear axle's centre on a circle about a point to its right, written without the paper's formulas.
Eigen::Isometry3d VehicleOnCircle(const AckermannStep& step) {
  const double radius = step.rho / (2.0 * std::sin(0.5 * step.psi));
  const Eigen::AngleAxisd turn(step.psi, Eigen::Vector3d::UnitY());
  const Eigen::Vector3d centre(radius, 0, 0);
  Eigen::Isometry3d previous_from_current = Eigen::Isometry3d::Identity();
  previous_from_current.linear() = turn.toRotationMatrix();
  previous_from_current.translation() = centre - turn * centre;
  return previous_from_current;
}

double Difference(const RigidTransform& a, const Eigen::Isometry3d& b) {
  return (a.rotation.toRotationMatrix() - b.rotation()).norm() + (a.translation - b.translation()).norm();
}

TEST(Ackermann, VehicleMovesOnACircle) {
  std::mt19937 random(11);
  for (int i = 0; i < 100; ++i) {
    const RandomStep drawn = Draw(random);
    EXPECT_LT(Difference(ConstrainedVehicleMotion(drawn.step), VehicleOnCircle(drawn.step)), 1e-12);
  }
}

TEST(Ackermann, CameraIsCarriedByTheVehicle) {
  std::mt19937 random(12);
  for (int i = 0; i < 100; ++i) {
    const RandomStep drawn = Draw(random);
    Eigen::Isometry3d vehicle_from_auxiliary = Eigen::Isometry3d::Identity();
    vehicle_from_auxiliary.translation() = drawn.lever_arm * Eigen::Vector3d::UnitZ();
    const Eigen::Isometry3d auxiliary =
        vehicle_from_auxiliary.inverse() * VehicleOnCircle(drawn.step) * vehicle_from_auxiliary;
    EXPECT_LT(Difference(ConstrainedAuxiliaryMotion(drawn.step, drawn.lever_arm), auxiliary), 1e-12);

    const Eigen::Isometry3d auxiliary_from_camera(drawn.vehicle_from_camera);
    const Eigen::Isometry3d camera = auxiliary_from_camera.inverse() * auxiliary * auxiliary_from_camera;
    EXPECT_LT(Difference(ConstrainedCameraMotion(drawn.step, drawn.lever_arm, drawn.vehicle_from_camera), camera),
              1e-12);
  }
}

TEST(Ackermann, RightTurnSwingsTheCameraToTheRight) {
  const AckermannStep right{0.1, 1.0};
  EXPECT_GT(ConstrainedVehicleMotion(right).translation.x(), 0);
  EXPECT_GT(ConstrainedAuxiliaryMotion(right, 1.0).translation.x(), ConstrainedVehicleMotion(right).translation.x());
}

TEST(Ackermann, DistanceAndDirectionAreThoseOfTheMotion) {
  std::mt19937 random(13);
  for (int i = 0; i < 100; ++i) {
    const auto [step, lever_arm, unused] = Draw(random);
    const Eigen::Vector3d travel = ConstrainedAuxiliaryMotion(step, lever_arm).translation;
    EXPECT_NEAR(CameraDistance(step, lever_arm), travel.norm(), 1e-13);
    EXPECT_NEAR(DirectionOfTravel(step, lever_arm), std::atan2(travel.x(), travel.z()), 1e-12);
  }
}

TEST(Ackermann, DirectionAgreesWithThePrintedTangent) {
  std::mt19937 random(14);
  for (int i = 0; i < 100; ++i) {
    const auto [step, lever_arm, unused] = Draw(random);
    const double sine = std::sin(0.5 * step.psi);
    const double tangent = std::tan(0.5 * step.psi);
    const double printed = (step.rho * tangent + 2 * lever_arm * sine) / (step.rho - 2 * lever_arm * sine * tangent);
    EXPECT_NEAR(std::tan(DirectionOfTravel(step, lever_arm)) / printed, 1.0, 1e-10);
  }
}

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

constexpr double kStep = 1e-6;  // rad
constexpr int kDraws = 20000;

TEST(ScaleObserver, ExactOnConstrainedMotion) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const double side = uniform(random);
    const AckermannStep step{std::copysign(0.02 + 0.3 * std::abs(uniform(random)), side), 1.2 + uniform(random)};
    const double lever_arm = 1.5 + uniform(random);
    const double theta = DirectionOfTravel(step, lever_arm);
    const double truth = CameraDistance(step, lever_arm);
    EXPECT_NEAR(ObservedDistance(step.psi, theta, lever_arm) / truth, 1.0, 1e-11);
    const double sine_rule = 2 * lever_arm * std::sin(step.psi) / (std::sin(theta) - std::sin(step.psi - theta));
    EXPECT_NEAR(sine_rule / truth, 1.0, 1e-11) << "the mended form of (22)";
  }
}

TEST(ScaleObserver, ExactOnASlippingCarEitherWay) {
  const LeverArm lever_arm{1.2, 0.005};
  const Eigen::Quaterniond identity = Eigen::Quaterniond::Identity();
  for (const double psi : {0.06, -0.06}) {
    const TurningMotion motion =
        TurningMotionOf(SlippingCameraMotion({1, 0.9, psi}, 0.1, lever_arm, identity), identity);
    EXPECT_NEAR(ObservedDistance(motion.psi, motion.theta, 0.1, lever_arm), 0.9, 1e-12);
    EXPECT_GT(ObservedDistance(motion.psi, motion.theta, lever_arm.length), 1.3) << "the rigid car is far off here";
    EXPECT_EQ(ObservedDistance(motion.psi, motion.theta, 0.1, {1.2, 0}),
              ObservedDistance(motion.psi, motion.theta, 1.2));
  }
}

TEST(ScaleObserver, ContradictionGivesNoPositiveDistance) {
  EXPECT_LT(ObservedDistance(0.1, 0.04, 1.0), 0) << "the camera swings inwards";
  EXPECT_FALSE(std::isfinite(ObservedDistance(0.1, 0.05, 1.0))) << "the camera moves along the chord of the axle";
}

TEST(ScaleObserver, DerivativesAgreeWithFiniteDifferences) {
  for (const double psi : {-0.3, -0.04, 0.05, 0.2}) {
    for (const double ratio : {0.6, 0.8, 1.1}) {
      const double theta = ratio * psi;
      const double by_psi =
          (ObservedDistance(psi + kStep, theta, 1) - ObservedDistance(psi - kStep, theta, 1)) / (2 * kStep);
      const double by_theta =
          (ObservedDistance(psi, theta + kStep, 1) - ObservedDistance(psi, theta - kStep, 1)) / (2 * kStep);
      const ScaleSensitivity sensitivity = SensitivityOfScale(psi, theta);
      EXPECT_NEAR(sensitivity.by_psi / by_psi, 1.0, 1e-5);
      EXPECT_NEAR(sensitivity.by_theta / by_theta, 1.0, 1e-5);
    }
  }
}

TEST(ScaleObserver, SensitivityGivesTheSpreadOfNoisyAngles) {
  const AckermannStep step{0.08, 0.5};
  const double theta = DirectionOfTravel(step, 1.0);
  const double sigma_psi = 2e-4;
  const double sigma_theta = 5e-4;
  std::mt19937 random(22);
  std::normal_distribution<double> normal;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double noisy_psi = step.psi + sigma_psi * normal(random);
    const double s = ObservedDistance(noisy_psi, theta + sigma_theta * normal(random), 1.0);
    sum += s;
    squares += s * s;
  }
  const double mean = sum / kDraws;
  const double spread = std::sqrt(squares / kDraws - mean * mean);
  const ScaleSensitivity sensitivity = SensitivityOfScale(step.psi, theta);
  const double sigma = std::hypot(sensitivity.by_psi * sigma_psi, sensitivity.by_theta * sigma_theta);
  EXPECT_NEAR(sigma / spread, 1.0, 0.015);
}

}  // namespace
}  // namespace turnscale
