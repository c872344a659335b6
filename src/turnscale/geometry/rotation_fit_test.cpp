// SPDX-License-Identifier: MIT
#include "turnscale/geometry/rotation_fit.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

TEST(RotationFit, ExactForARotationAlone) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const Eigen::Quaterniond rotation = RotationFromVector({0.1, -0.3, 0.2});
  std::vector<Eigen::Vector3d> first;
  std::vector<Eigen::Vector3d> second;
  for (int i = 0; i < 20; ++i) {
    first.emplace_back(normal(random), normal(random), 3.0);
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
    first.emplace_back(normal(random), normal(random), 3.0);
    const Eigen::Vector3d moved = first.back() + (i % 3 == 0 ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d::Zero());
    second.emplace_back(rotation * moved);
  }
  EXPECT_LT(RotationAngle(FitRotation(first, second) * rotation.conjugate()) * kDegreesPerRadian, 0.01);
}

}  // namespace
}  // namespace turnscale
