// SPDX-License-Identifier: MIT
#include "turnscale/geometry/rotation.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {
namespace {

TEST(Rotation, VectorRoundTripFromTinyToNearlyPi) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3, 0.1, 1.0, 3.0, 3.14159}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d v = angle * DrawVector<3>([&] { return normal(random); }).normalized();
      const Eigen::Vector3d back = VectorFromRotation(RotationFromVector(v));
      EXPECT_LT((back - v).norm(), 1e-15 + 1e-12 * angle) << "angle " << angle;
    }
  }
}

TEST(Rotation, VectorAgreesWithAngleAxis) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d v = DrawVector<3>([&] { return uniform(random); });
    const Eigen::Matrix3d expected = Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix();
    EXPECT_LT((RotationFromVector(v).toRotationMatrix() - expected).norm(), 1e-14);
    EXPECT_NEAR(RotationAngle(RotationFromVector(v)), v.norm(), 1e-13);
  }
}

TEST(Rotation, TwistIgnoresPitchAndRollToFirstOrderAndSign) {
  const double yaw = 0.05;
  const Eigen::Quaterniond turn = RotationFromVector({0, yaw, 0});
  EXPECT_NEAR(TwistAboutY(turn), yaw, 1e-15);
  EXPECT_NEAR(TwistAboutY(Eigen::Quaterniond(-turn.coeffs())), yaw, 1e-15);
  EXPECT_NEAR(TwistAboutY(RotationFromVector({0.01, yaw, -0.01})), yaw, 1e-5);
}

TEST(Rotation, YawPitchRollRoundTripAndDirections) {
  const YawPitchRoll angles{0.3, -0.2, 0.1};
  const YawPitchRoll back = YawPitchRollFromRotation(RotationFromYawPitchRoll(angles));
  EXPECT_NEAR(back.yaw, angles.yaw, 1e-14);
  EXPECT_NEAR(back.pitch, angles.pitch, 1e-14);
  EXPECT_NEAR(back.roll, angles.roll, 1e-14);
  const Eigen::Vector3d forward = Eigen::Vector3d::UnitZ();
  EXPECT_GT((RotationFromYawPitchRoll({0.1, 0, 0}) * forward).x(), 0) << "yaw > 0 looks right";
  EXPECT_LT((RotationFromYawPitchRoll({0, 0.1, 0}) * forward).y(), 0) << "pitch > 0 looks up";
  EXPECT_GT((RotationFromYawPitchRoll({0, 0, 0.1}) * Eigen::Vector3d::UnitX()).y(), 0) << "roll > 0 leans right";
}

TEST(RigidTransform, ComposesAndInverts) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return DrawVector<3>([&] { return normal(random); }); };
  for (int i = 0; i < 20; ++i) {
    const RigidTransform b_from_a{RotationFromVector(vector()), vector()};
    const RigidTransform c_from_b{RotationFromVector(vector()), vector()};
    const Eigen::Vector3d x = vector();
    EXPECT_LT(((c_from_b * b_from_a) * x - c_from_b * (b_from_a * x)).norm(), 1e-13);
    EXPECT_LT((b_from_a.inverse() * (b_from_a * x) - x).norm(), 1e-13);
  }
}

TEST(RotationFit, ExactForARotationAlone) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond rotation = RotationFromVector({0.1, -0.3, 0.2});
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> second;
  for (int i = 0; i < 20; ++i) {
    first.emplace_back(0, 0, 3);
    first.back().head<2>() = DrawVector<2>([&] { return normal(random); });
    second.emplace_back(2.0 * (rotation * first.back()));
  }
  EXPECT_LT(RotationAngle(FitRotation(first, second) * rotation.conjugate()), 1e-9);
}

TEST(RotationFit, IsNotPulledAwayByAThirdOfTheDirections) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond rotation = RotationFromVector({0, 0.1, 0});
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> second;
  for (int i = 0; i < 90; ++i) {
    first.emplace_back(0, 0, 3);
    first.back().head<2>() = DrawVector<2>([&] { return normal(random); });
    const Eigen::Vector3d moved = first.back() + (i % 3 == 0 ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d::Zero());
    second.emplace_back(rotation * moved);
  }
  EXPECT_LT(RotationAngle(FitRotation(first, second) * rotation.conjugate()) * kDegreesPerRadian, 0.01);
}

}  // namespace
}  // namespace turnscale
