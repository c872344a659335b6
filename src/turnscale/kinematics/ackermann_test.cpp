// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/ackermann.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

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

TEST(Ackermann, TravelComesBackFromTheAngles) {
  std::mt19937 random(15);
  for (int i = 0; i < 100; ++i) {
    const auto [step, lever_arm, unused] = Draw(random);
    const double theta = DirectionOfTravel(step, lever_arm);
    EXPECT_NEAR(TravelFromAngles(step.psi, theta, lever_arm), step.rho, 1e-9);
    const double printed = 2 * std::cos(0.5 * step.psi) * (std::sin(theta) + std::sin(step.psi - theta)) /
                           (std::sin(theta) - std::sin(step.psi - theta));
    EXPECT_NEAR(TravelFromAngles(step.psi, theta, 1.0), printed, 1e-6 * std::abs(printed));
  }
}

}  // namespace
}  // namespace turnscale
