// SPDX-License-Identifier: MIT
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/bundle/synthetic_drive.h"

namespace turnscale {
namespace {

SyntheticDrive Drive(double pixel_noise) {
  SyntheticDriveOptions options;
  options.cameras = 40;
  options.points = 1500;
  options.observations = 9000;
  options.turn_every = 20;
  options.turn_length = 6;
  options.pixel_noise = pixel_noise;
  return MakeSyntheticDrive(options);
}

/// As the absolute scale recovery asks (26): rotations fixed, only the first camera fixed.
BundleOptions Recovery() {
  BundleOptions options;
  options.fix_rotations = true;
  options.max_iterations = 14;
  options.relative_cost_tolerance = 0;
  options.kkt_tolerance = 1e-8;
  return options;
}

TEST(DistanceConstraints, BringBackTheTrueScaleWithoutNoise) {
  const SyntheticDrive drive = Drive(0);
  for (const auto& [first, last] : {std::pair(1.1, 1.1), std::pair(0.9, 0.9), std::pair(0.75, 1.35)}) {
    BundleProblem problem = drive.truth;
    problem.distances = TurnDistances(drive, 6);
    DriftScale(first, last, problem);
    const BundleSummary summary = AdjustBundle(Recovery(), problem);
    EXPECT_TRUE(summary.converged) << summary.message;
    for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
      EXPECT_LT((Centre(problem, i) - Centre(drive.truth, i)).norm(), 1e-6) << "camera " << i;
    }
  }
}

TEST(DistanceConstraints, ReachStationarityFromTurnsThatDisagreeByTensOfPercent) {
  const SyntheticDrive drive = Drive(0.5);
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::vector<DistanceConstraint> distances = TurnDistances(drive, 8);
  // Observed scales are noisy; the constraints then pull against the images.
  for (DistanceConstraint& held : distances) held.distance *= 1 + 0.03 * normal(random);
  double cost = -1;
  for (const auto& [first, last] : {std::pair(1.1, 1.1), std::pair(0.7, 1.4), std::pair(1.5, 0.8)}) {
    BundleProblem problem = drive.truth;
    problem.distances = distances;
    Disturb(0.02, 0, 0.02, 5, problem);
    DriftScale(first, last, problem);
    const BundleSummary summary = AdjustBundle(Recovery(), problem);
    EXPECT_TRUE(summary.converged) << summary.message << ", KKT " << summary.kkt_residual;
    EXPECT_LT(summary.kkt_residual, 1e-8);
    EXPECT_LT(summary.constraint_residual, 1e-9);
    for (const DistanceConstraint& held : problem.distances) {
      const double distance = (Centre(problem, held.camera_a) - Centre(problem, held.camera_b)).norm();
      EXPECT_NEAR(distance, held.distance, 1e-9 * held.distance);
    }
    if (cost < 0) cost = summary.final_cost;
    EXPECT_NEAR(summary.final_cost, cost, 1e-9 * cost) << "one optimum from every start";
  }
}

TEST(DistanceConstraints, RecoverALongDriveInFewIterations) {
  SyntheticDriveOptions drive_options;
  drive_options.cameras = 300;
  drive_options.points = 30000;
  drive_options.observations = 200000;
  const SyntheticDrive drive = MakeSyntheticDrive(drive_options);
  BundleProblem problem = drive.truth;
  problem.distances = TurnDistances(drive, 40);
  ASSERT_EQ(problem.distances.size(), 40);
  ASSERT_GT(problem.observations.size(), 199000);
  Disturb(0.02, 0, 0.02, 2, problem);
  DriftScale(1.1, 1.1, problem);
  const BundleSummary summary = AdjustBundle(Recovery(), problem);
  EXPECT_LT(summary.iterations, 15);
  EXPECT_LT(summary.kkt_residual, 1e-8);
  EXPECT_LT(summary.constraint_residual, 1e-9);
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    EXPECT_LT((Centre(problem, i) - Centre(drive.truth, i)).norm(), 0.13) << "camera " << i;
  }
}

TEST(DistanceConstraints, DoNotDependOnTheUnitOfLength) {
  const SyntheticDrive drive = Drive(0.5);
  const auto adjusted = [&](double scale) {
    BundleProblem problem = drive.truth;
    problem.distances = TurnDistances(drive, 6);
    DriftScale(0.8, 1.2, problem);
    for (RigidTransform& pose : problem.camera_from_world) pose.translation *= scale;
    for (Eigen::Vector3d& point : problem.points) point *= scale;
    for (DistanceConstraint& held : problem.distances) held.distance *= scale;
    BundleOptions options = Recovery();
    options.kkt_tolerance = 1e-10;
    EXPECT_TRUE(AdjustBundle(options, problem).converged);
    return problem;
  };
  const BundleProblem metres = adjusted(1);
  for (const double scale : {0.1, 10.0}) {
    const BundleProblem scaled = adjusted(scale);
    const double length = Centre(metres, metres.camera_from_world.size() - 1).norm();
    for (std::size_t i = 0; i < metres.camera_from_world.size(); ++i) {
      EXPECT_LT((Centre(scaled, i) / scale - Centre(metres, i)).norm(), 1e-9 * length);
    }
  }
}

TEST(DistanceConstraints, HoldWithFreeRotationsToo) {
  const SyntheticDrive drive = Drive(0.5);
  BundleProblem problem = drive.truth;
  problem.distances = TurnDistances(drive, 6);
  Disturb(0.02, 0.001, 0.02, 6, problem);
  DriftScale(1.1, 1.1, problem);
  BundleOptions options = Recovery();
  options.fix_rotations = false;
  options.max_iterations = 30;
  const BundleSummary summary = AdjustBundle(options, problem);
  EXPECT_TRUE(summary.converged) << summary.message << ", KKT " << summary.kkt_residual;
  EXPECT_LT(summary.constraint_residual, 1e-9);
}

TEST(DistanceConstraints, CostAtLeastWhatTheFreeProblemCosts) {
  const SyntheticDrive drive = Drive(0.5);
  BundleProblem free = drive.truth;
  BundleProblem held = drive.truth;
  held.distances = TurnDistances(drive, 6);
  for (DistanceConstraint& distance : held.distances) distance.distance *= distance.camera_a % 2 ? 1.05 : 0.95;
  const BundleSummary free_summary = AdjustBundle(Recovery(), free);
  const BundleSummary held_summary = AdjustBundle(Recovery(), held);
  EXPECT_GT(held_summary.final_cost, free_summary.final_cost + 1);
}

}  // namespace
}  // namespace turnscale
