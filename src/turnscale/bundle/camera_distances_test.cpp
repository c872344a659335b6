// SPDX-License-Identifier: MIT
#include "turnscale/bundle/camera_distances.h"

#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

constexpr double kCentreStep = 1e-5;

std::vector<Eigen::Vector3d> RandomCentres(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> centres(3);
  for (Eigen::Vector3d& centre : centres) centre = {normal(random), normal(random), normal(random)};
  return centres;
}

TEST(Constraints, DerivativesAgainstDifferences) {
  const DistanceConstraint held{2, 0, 0.8};
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const std::vector<Eigen::Vector3d> centres = RandomCentres(seed);
    const LinearizedDistance linear = LinearizeDistance(held, centres);
    EXPECT_DOUBLE_EQ(linear.value, (centres[2] - centres[0]).norm() / 0.8 - 1.0);
    for (int i = 0; i < 3; ++i) {
      for (const auto& [camera, sign] : {std::pair(2, 1.0), std::pair(0, -1.0)}) {
        std::vector<Eigen::Vector3d> above = centres;
        std::vector<Eigen::Vector3d> below = centres;
        above[camera][i] += kCentreStep;
        below[camera][i] -= kCentreStep;
        const double slope = (DistanceError(held, above) - DistanceError(held, below)) / (2 * kCentreStep);
        EXPECT_NEAR(sign * linear.gradient[i], slope, 1e-8);
        const Eigen::Vector3d bend =
            (LinearizeDistance(held, above).gradient - LinearizeDistance(held, below).gradient) / (2 * kCentreStep);
        EXPECT_LT((sign * linear.curvature.col(i) - bend).norm(), 1e-7);
      }
    }
  }
}

TEST(Constraints, LargestErrorIsTheWorstOfAll) {
  const std::vector<Eigen::Vector3d> centres = {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}};
  EXPECT_EQ(LargestDistanceError({}, centres), 0.0);
  EXPECT_DOUBLE_EQ(LargestDistanceError({{0, 1, 1.0}, {1, 2, 4.0}}, centres), 0.5);
}

TEST(Constraints, CoincidingCentresAreRefused) {
  const std::vector<Eigen::Vector3d> centres = {{1, 2, 3}, {1, 2, 3}};
  BundleProblem held;
  held.distances = {{0, 1, 1.0}};
  BundleProblem measured;
  measured.measured_distances = {{{0, 1, 1.0}, 0.1}};
  for (const BundleProblem& problem : {held, measured}) {
    EXPECT_THROW(RequireSeparateCentres(problem, centres), NumericalError);
    EXPECT_NO_THROW(RequireSeparateCentres(problem, {{1, 2, 3}, {1, 2, 3.001}}));
  }
}

}  // namespace
}  // namespace turnscale
