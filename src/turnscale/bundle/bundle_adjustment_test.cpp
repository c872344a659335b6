// SPDX-License-Identifier: MIT
#include "turnscale/bundle/bundle_adjustment.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core/utility.hpp>

#include "turnscale/bundle/ceres_reference.h"
#include "turnscale/bundle/parts.h"
#include "turnscale/bundle/synthetic_drive.h"

namespace turnscale {
namespace {

/// A window of a drive, disturbed; the first two cameras are fixed, so that the scale is known.
BundleProblem Window(unsigned seed, double outliers) {
  SyntheticDriveOptions options;
  options.cameras = 8;
  options.points = 150;
  options.observations = 750;
  options.turn_every = 5;
  options.turn_length = 3;
  options.outliers = outliers;
  options.seed = seed;
  BundleProblem problem = MakeSyntheticDrive(options).truth;
  problem.camera_is_fixed[1] = 1;
  Disturb(0.05, 0.003, 0.05, seed, problem);
  return problem;
}

BundleOptions Tight() {
  BundleOptions options;
  options.max_iterations = 100;
  options.relative_cost_tolerance = 0;
  options.kkt_tolerance = 1e-9;
  return options;
}

void ScaleWorld(double scale, BundleProblem& problem) {
  for (RigidTransform& pose : problem.camera_from_world) pose.translation *= scale;
  for (Eigen::Vector3d& point : problem.points) point *= scale;
  for (DistanceConstraint& held : problem.distances) held.distance *= scale;
}

void ExpectSamePlaces(const BundleProblem& a, const BundleProblem& b, double tolerance) {
  for (std::size_t i = 0; i < a.camera_from_world.size(); ++i) {
    EXPECT_LT((Centre(a, i) - Centre(b, i)).norm(), tolerance) << "camera " << i;
    EXPECT_LT(RotationAngle(a.camera_from_world[i].rotation.conjugate() * b.camera_from_world[i].rotation), tolerance)
        << "camera " << i;
  }
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_LT((a.points[i] - b.points[i]).norm(), tolerance * (1 + a.points[i].norm())) << "point " << i;
  }
}

TEST(BundleAdjustment, FindsTheTruthWithoutNoise) {
  SyntheticDriveOptions drive;
  drive.points = 100;
  drive.observations = 500;
  drive.pixel_noise = 0;
  const BundleProblem truth = MakeSyntheticDrive(drive).truth;
  BundleProblem problem = truth;
  problem.camera_is_fixed[1] = 1;
  Disturb(0.05, 0.005, 0.05, 3, problem);
  const BundleSummary summary = AdjustBundle(Tight(), problem);
  EXPECT_TRUE(summary.converged) << summary.message;
  EXPECT_GT(summary.initial_cost, 1e3);
  EXPECT_LT(summary.final_cost, 1e-12);
  ExpectSamePlaces(problem, truth, 1e-7);
}

BundleSummary ExpectCeresFindsTheSame(const BundleOptions& options, const BundleProblem& start) {
  BundleProblem ours = start;
  const BundleSummary summary = AdjustBundle(options, ours);
  EXPECT_TRUE(summary.converged) << summary.message;

  BundleProblem theirs = start;
  ceres::Solver::Options ceres_options;
  ceres_options.max_num_iterations = 1000;
  ceres_options.function_tolerance = 1e-16;
  ceres_options.gradient_tolerance = 1e-13;
  ceres_options.parameter_tolerance = 1e-14;
  const ceres::Solver::Summary reference = AdjustWithCeres(options, ceres_options, theirs);
  EXPECT_NEAR(summary.initial_cost, reference.initial_cost, 1e-10 * reference.initial_cost);
  EXPECT_NEAR(summary.final_cost, reference.final_cost, 1e-8 * reference.final_cost);
  ExpectSamePlaces(ours, theirs, 1e-5);
  return summary;
}

class AgainstCeres : public testing::TestWithParam<std::tuple<double, bool>> {};

TEST_P(AgainstCeres, SameOptimum) {
  const auto [outliers, fix_rotations] = GetParam();
  BundleOptions options = Tight();
  options.fix_rotations = fix_rotations;
  EXPECT_LT(ExpectCeresFindsTheSame(options, Window(4, outliers)).kkt_residual, 1e-9);
}

// Distances that contradict the images by as much as their sigmas allow for.
TEST(BundleAdjustment, WeighsMeasuredDistancesAsCeresDoes) {
  BundleProblem start = Window(4, 0.03);
  for (int k = 1; k < static_cast<int>(start.camera_from_world.size()); ++k) {
    if (start.camera_is_fixed[k] && start.camera_is_fixed[k - 1]) continue;
    start.measured_distances.push_back({{k - 1, k, 1.0 + 0.02 * (k % 3)}, 0.001 * (1 + k % 2)});
  }
  for (const bool fix_rotations : {false, true}) {
    BundleOptions options = Tight();
    options.fix_rotations = fix_rotations;
    ExpectCeresFindsTheSame(options, start);
  }
}

INSTANTIATE_TEST_SUITE_P(OutliersAndRotations, AgainstCeres,
                         testing::Combine(testing::Values(0.0, 0.03), testing::Bool()));

TEST(BundleAdjustment, DoesNotDependOnTheUnitOfLength) {
  const BundleProblem start = Window(5, 0.0);
  BundleProblem metres = start;
  const BundleSummary summary = AdjustBundle(Tight(), metres);
  for (const double scale : {0.1, 10.0}) {
    BundleProblem scaled = start;
    ScaleWorld(scale, scaled);
    const BundleSummary other = AdjustBundle(Tight(), scaled);
    EXPECT_EQ(other.iterations, summary.iterations);
    EXPECT_NEAR(other.final_cost, summary.final_cost, 1e-12 * summary.final_cost);
    ScaleWorld(1 / scale, scaled);
    ExpectSamePlaces(scaled, metres, 1e-9);
  }
}

TEST(BundleAdjustment, TwoRunsGiveTheSameBits) {
  BundleProblem first = Window(6, 0.03);
  BundleProblem second = first;
  AdjustBundle({}, first);
  AdjustBundle({}, second);
  EXPECT_EQ(std::memcmp(first.points.data(), second.points.data(), first.points.size() * sizeof(first.points[0])), 0);
  for (std::size_t i = 0; i < first.camera_from_world.size(); ++i) {
    EXPECT_EQ(first.camera_from_world[i].translation, second.camera_from_world[i].translation);
    EXPECT_EQ(first.camera_from_world[i].rotation.coeffs(), second.camera_from_world[i].rotation.coeffs());
  }
}

TEST(BundleAdjustment, LeavesFixedThingsAloneToTheLastBit) {
  const BundleProblem start = Window(7, 0.0);
  BundleProblem problem = start;
  BundleOptions options;
  options.fix_rotations = true;
  AdjustBundle(options, problem);
  for (std::size_t i = 0; i < start.camera_from_world.size(); ++i) {
    EXPECT_EQ(problem.camera_from_world[i].rotation.coeffs(), start.camera_from_world[i].rotation.coeffs());
    EXPECT_EQ(problem.camera_from_world[i].translation == start.camera_from_world[i].translation, i < 2);
  }
}

TEST(BundleAdjustment, RobustLossShrugsOffOutliers) {
  SyntheticDriveOptions drive;
  drive.points = 300;
  drive.observations = 1800;
  drive.outliers = 0.05;
  const BundleProblem truth = MakeSyntheticDrive(drive).truth;
  const auto worst_error = [&](double threshold) {
    BundleProblem problem = truth;
    problem.camera_is_fixed[1] = 1;
    Disturb(0.03, 0.002, 0.03, 8, problem);
    BundleOptions options;
    options.max_iterations = 50;
    options.huber_threshold = threshold;
    AdjustBundle(options, problem);
    double worst = 0;
    for (std::size_t i = 0; i < truth.camera_from_world.size(); ++i) {
      worst = std::max(worst, (Centre(problem, i) - Centre(truth, i)).norm());
    }
    return worst;
  };
  EXPECT_LT(worst_error(2.0), 0.035);
  EXPECT_GT(worst_error(0.0), 7.0 * worst_error(2.0)) << "plain least squares should suffer";
}

TEST(BundleAdjustment, StopsAtTheIterationLimit) {
  BundleProblem problem = Window(9, 0.0);
  BundleOptions options = Tight();
  options.max_iterations = 1;
  const BundleSummary summary = AdjustBundle(options, problem);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_FALSE(summary.converged);
  EXPECT_EQ(summary.message, "iteration limit");
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_GT(summary.kkt_residual, 1e-9);
}

TEST(BundleAdjustment, HasTheSameBitsOnAnyNumberOfThreads) {
  const int before = cv::getNumThreads();
  const auto adjusted = [](int threads, const BundleOptions& options) {
    cv::setNumThreads(threads);
    BundleProblem problem = Window(4, 0.05);
    EXPECT_GT(PartsOf(problem.points.size()).size(), 2U) << "there is more than one part";
    AdjustBundle(options, problem);
    return problem;
  };
  for (const bool fix_rotations : {false, true}) {
    BundleOptions options;
    options.fix_rotations = fix_rotations;
    const BundleProblem one = adjusted(1, options);
    for (const int threads : {2, 3, 8}) {
      const BundleProblem other = adjusted(threads, options);
      EXPECT_EQ(other.points, one.points) << threads;
      for (std::size_t i = 0; i < one.camera_from_world.size(); ++i) {
        EXPECT_EQ(other.camera_from_world[i].rotation.coeffs(), one.camera_from_world[i].rotation.coeffs());
        EXPECT_EQ(other.camera_from_world[i].translation, one.camera_from_world[i].translation);
      }
    }
  }
  cv::setNumThreads(before);
}

TEST(BundleAdjustment, PartsHoldAllPoints) {
  for (const std::size_t points : {0, 1, 99, 100, 1234}) {
    const std::vector<std::size_t> bounds = PartsOf(points);
    EXPECT_EQ(bounds.front(), 0U);
    EXPECT_EQ(bounds.back(), points);
    EXPECT_TRUE(std::ranges::is_sorted(bounds));
  }
}

}  // namespace
}  // namespace turnscale
