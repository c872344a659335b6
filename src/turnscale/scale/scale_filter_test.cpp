// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_filter.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

constexpr double kMetresPerUnit = 15;
constexpr double kExact = 1e-9;  // standard deviation of what is known exactly

ScaleProblem RandomProblem(int segments, std::uint64_t seed = 5) {
  Random random(seed);
  ScaleProblem problem;
  problem.prior.mean << std::log(kMetresPerUnit), 0.001, 0.005, 0, std::log(1.2), 1.1, std::log(1.5), 0;
  problem.prior.covariance.diagonal() << 4, 3e-5, 4e-6, 1e-3, 1e-3, 0.1, 2e-2, 1;
  double middle = 0;
  for (int i = 0; i < segments; ++i) {
    const double length = random.Uniform(0.5, 8);
    PathSegment segment{.turning = i % 3 != 1, .length = length, .middle = middle + 0.5 * length};
    segment.angle = segment.turning ? random.Uniform(-2, 2) : random.Uniform(-0.1, 0.1);
    segment.turned = std::abs(segment.angle);
    middle += length;
    SegmentEvidence evidence;
    if (segment.turning) {
      const double speed = random.Uniform(0.1, 0.6);
      evidence.turn = PooledLine{
          .lever_arm = 1.2 / kMetresPerUnit - 0.004 * kMetresPerUnit * speed * speed + 0.002 * random.Gaussian(),
          .sigma = random.Uniform(2e-4, 2e-3),
          .by_direction = random.Uniform(-1, 1),
          .by_roll_height = random.Uniform(-0.02, 0.02),
          .mean_square_speed = speed * speed,
          .mean_speed = speed};
      if (i % 2 == 0)
        evidence.direction_in_turn = DirectionInTurn{.angle = 0.003 * random.Gaussian(),
                                                     .sigma = random.Uniform(0.002, 0.01),
                                                     .by_slip = random.Uniform(-0.2, 0.2),
                                                     .by_lag = random.Uniform(-0.2, 0.2)};
    } else {
      evidence.straight = StraightDirection{.angle = 0.01 * random.Gaussian(), .sigma = 0.002};
    }
    for (double& weight : problem.weights.emplace_back()) weight = random.Uniform(0.3, 1);
    if (i % 4 != 2)
      evidence.road = RoadEvidence{.log_height = std::log(1.5 / kMetresPerUnit) + 0.02 * random.Gaussian(),
                                   .sigma = random.Uniform(0.002, 0.02),
                                   .length = random.Uniform(0.3, 1) * length};
    problem.segments.push_back(segment);
    problem.evidence.push_back(evidence);
  }
  // Turns that show no lever arm, one of them a direction.
  for (const int turn : {2, 3})
    if (segments > 4) problem.evidence[turn].turn.reset();
  return problem;
}

std::vector<DriveState> SomeStates(const ScaleProblem& problem) {
  std::vector<DriveState> at(problem.segments.size(), problem.prior.mean);
  Random random(9);
  for (DriveState& state : at)
    state += DriveState{{0.05, 0.001, 0.0005, 0.01, 0.01, 0.1, 0.02, 0.3}} * random.Gaussian();
  return at;
}

constexpr Eigen::Index kConstants = kRoadError - kDirection;

// The column of an unknown in a segment: log-scales, constants, errors of the road.
Eigen::Index Column(Eigen::Index segments, Eigen::Index segment, int unknown) {
  if (unknown == kLogScale) return segment;
  return unknown == kRoadError ? segments + kConstants + segment : segments + unknown - 1;
}

// The same linear problem as one weighted least squares: a log-scale for each segment, then the car's constants in the
// order of DriveUnknown, then the road's error in each segment; those of `exact` taken out.
struct Dense {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};
Dense SolveDense(const ScaleProblem& problem, const std::vector<DriveState>& at, std::optional<int> exact = {}) {
  const auto n = static_cast<Eigen::Index>(at.size());
  const Eigen::Index unknowns = 2 * n + kConstants;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(kDriveUnknowns + 2 * (n - 1) + kMeasurementKinds * n, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(rows.rows());
  Eigen::Index row = 0;
  const auto column = [&](Eigen::Index segment, int unknown) { return Column(n, segment, unknown); };
  for (int unknown = 0; unknown < kDriveUnknowns; ++unknown, ++row) {
    if (unknown == exact) continue;
    const double sigma = std::sqrt(problem.prior.covariance(unknown, unknown));
    rows(row, column(0, unknown)) = 1 / sigma;
    right[row] = problem.prior.mean[unknown] / sigma;
  }
  for (Eigen::Index i = 1; i < n; ++i, ++row) {
    const PathSegment& a = problem.segments[i - 1];
    const PathSegment& b = problem.segments[i];
    const double metres = (b.middle - a.middle) * std::exp(at[i][0]);
    const double turned = 0.5 * (a.turned + b.turned) * 180 / std::numbers::pi;
    const double sigma = std::sqrt(std::pow(problem.drift.per_100m, 2) * metres / 100 +
                                   std::pow(problem.drift.per_90deg, 2) * turned / 90 + std::pow(b.gap_sigma, 2));
    rows(row, i) = 1 / sigma;
    rows(row, i - 1) = -1 / sigma;
    const double kept = std::exp(-metres / problem.options.road.correlation_length);
    ++row;
    rows(row, column(i, kRoadError)) = 1 / std::sqrt(1 - kept * kept);
    rows(row, column(i - 1, kRoadError)) = -kept / std::sqrt(1 - kept * kept);
  }
  const auto measure = [&](Eigen::Index i, const Measurement& measurement, double weight) {
    const double sigma = std::sqrt(measurement.variance / weight);
    for (int unknown = 0; unknown < kDriveUnknowns; ++unknown) {
      if (unknown == exact) {
        right[row] -= measurement.by_state[unknown] * problem.prior.mean[unknown] / sigma;
      } else {
        rows(row, column(i, unknown)) = measurement.by_state[unknown] / sigma;
      }
    }
    right[row] += (measurement.innovation + measurement.by_state.dot(at[i])) / sigma;
    ++row;
  };
  for (Eigen::Index i = 0; i < n; ++i)
    for (const auto& [kind, measurement] : MeasurementsOf(problem.evidence[i], at[i], problem.options))
      measure(i, measurement, problem.weights[i][kind]);
  // An unknown that is taken out has no rows: the solution of least norm leaves it at 0, and its covariance too.
  const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(rows);
  const Eigen::MatrixXd inverse = solver.pseudoInverse();
  Dense dense{inverse * right, inverse * inverse.transpose()};
  if (exact) dense.mean[column(0, *exact)] = problem.prior.mean[*exact];
  return dense;
}

double DenseLengthSigma(const Dense& dense, const std::vector<PathSegment>& segments) {
  const auto n = static_cast<Eigen::Index>(segments.size());
  Eigen::VectorXd metres(n);
  for (Eigen::Index i = 0; i < n; ++i) metres[i] = std::exp(dense.mean[i]) * segments[i].length;
  return std::sqrt(metres.dot(dense.covariance.topLeftCorner(n, n) * metres)) / metres.sum();
}

void ExpectDense(const SmoothedScale& smoothed, const Dense& dense) {
  const auto n = static_cast<Eigen::Index>(smoothed.segments.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const ScaleBelief& belief = smoothed.segments[i];
    const auto place = [&](int unknown) { return Column(n, i, unknown); };
    for (int r = 0; r < kDriveUnknowns; ++r) {
      const double sigma_r = std::sqrt(dense.covariance(place(r), place(r)));
      EXPECT_NEAR(belief.mean[r], dense.mean[place(r)], 1e-6 * sigma_r + 1e-9) << i << ' ' << r;
      for (int c = 0; c < kDriveUnknowns; ++c) {
        const double sigma_c = std::sqrt(dense.covariance(place(c), place(c)));
        EXPECT_NEAR(belief.covariance(r, c), dense.covariance(place(r), place(c)), 1e-6 * sigma_r * sigma_c + 1e-15)
            << i << ' ' << r << ' ' << c;
      }
    }
  }
}

TEST(ScaleFilter, SmootherIsTheDenseLeastSquares) {
  for (const int segments : {1, 2, 12, 60}) {
    ScaleProblem problem = RandomProblem(segments);
    if (segments > 9) problem.segments[7].gap_sigma = 0.3;
    const std::vector<DriveState> at = SomeStates(problem);
    const Dense dense = SolveDense(problem, at);
    const SmoothedScale smoothed = SmoothScale(problem, at);
    ASSERT_EQ(smoothed.segments.size(), static_cast<std::size_t>(segments));
    ExpectDense(smoothed, dense);
    EXPECT_NEAR(LengthSigma(smoothed, problem.segments) / DenseLengthSigma(dense, problem.segments), 1, 1e-6);
  }
}

TEST(ScaleFilter, WhatIsKnownExactlyStays) {
  for (const int exact : {static_cast<int>(kSlip), static_cast<int>(kLogLeverArm), static_cast<int>(kDirection),
                          static_cast<int>(kRollHeight), static_cast<int>(kLogHeight)}) {
    ScaleProblem problem = RandomProblem(20);
    problem.prior.covariance(exact, exact) = kExact * kExact;
    const std::vector<DriveState> at = SomeStates(problem);
    const Dense dense = SolveDense(problem, at, exact);
    const SmoothedScale smoothed = SmoothScale(problem, at);
    ExpectDense(smoothed, dense);
    for (const ScaleBelief& belief : smoothed.segments)
      EXPECT_NEAR(belief.mean[exact], problem.prior.mean[exact], 1e-8);
    EXPECT_NEAR(LengthSigma(smoothed, problem.segments) / DenseLengthSigma(dense, problem.segments), 1, 1e-6);
  }
}

TEST(ScaleFilter, ConstantsThatAreKnownExactlyLeaveTheScale) {
  ScaleProblem problem = RandomProblem(15);
  for (const int exact : {static_cast<int>(kSlip), static_cast<int>(kLogLeverArm)})
    problem.prior.covariance(exact, exact) = kExact * kExact;
  problem.drift = {1e-5, 0};
  const std::vector<DriveState> at(15, problem.prior.mean);
  const SmoothedScale smoothed = SmoothScale(problem, at);
  for (const ScaleBelief& belief : smoothed.segments) {
    EXPECT_NEAR(belief.mean[kLogScale], smoothed.segments[0].mean[kLogScale], 1e-6) << "it hardly drifts";
    EXPECT_TRUE((belief.covariance.diagonal().array() >= 0).all());
  }
}

TEST(ScaleFilter, AGapForgetsTheScaleBeforeIt) {
  ScaleProblem problem = RandomProblem(10);
  const std::vector<DriveState> at = SomeStates(problem);
  const SmoothedScale whole = SmoothScale(problem, at);
  problem.segments[5].gap_sigma = 0.3;
  const SmoothedScale broken = SmoothScale(problem, at);
  EXPECT_GT(broken.segments[4].sigma(), whole.segments[4].sigma());
  EXPECT_GT(broken.segments[5].sigma(), whole.segments[5].sigma());
}

TEST(ScaleFilter, LengthOfOneSegmentIsAsUncertainAsItsScale) {
  const ScaleProblem problem = RandomProblem(1);
  const SmoothedScale smoothed = SmoothScale(problem, {problem.prior.mean});
  EXPECT_NEAR(LengthSigma(smoothed, problem.segments), smoothed.segments[0].sigma(), 1e-12);
}

TEST(ScaleFilter, NoLengthHasNoSigma) { EXPECT_TRUE(std::isinf(LengthSigma({}, {}))); }

TEST(ScaleFilter, UpdateIsTheSumOfInformation) {
  Random random(6);
  for (int draw = 0; draw < 50; ++draw) {
    const auto vector = [&] { return DriveState::NullaryExpr([&] { return random.Gaussian(); }).eval(); };
    DriveCovariance root;
    for (int i = 0; i < kDriveUnknowns; ++i) root.col(i) = vector();
    const ScaleBelief belief{vector(), root * root.transpose() + 0.1 * DriveCovariance::Identity()};
    const Measurement measurement{random.Gaussian(), random.Uniform(0.1, 2), vector().transpose()};
    const double weight = random.Uniform(0.1, 1);
    const DriveState at = vector();
    const ScaleBelief updated = Updated(belief, measurement, weight, at);
    const DriveCovariance before = belief.covariance.inverse();
    const DriveCovariance gained =
        measurement.by_state.transpose() * measurement.by_state * (weight / measurement.variance);
    const DriveCovariance covariance = (before + gained).inverse();
    EXPECT_LT((updated.covariance - covariance).norm(), 1e-9 * covariance.norm());
    const double value = measurement.innovation + measurement.by_state.dot(at);
    const DriveState mean = covariance * (before * belief.mean +
                                          measurement.by_state.transpose() * value * (weight / measurement.variance));
    EXPECT_LT((updated.mean - mean).norm(), 1e-8 * (1 + mean.norm()));
  }
}

TEST(Drift, GathersOverDistanceTurningAndGaps) {
  const DriftOptions drift{0.02, 0.01};
  const auto sigma = [&](double length, double unit, double angle, double gap) {
    return std::sqrt(DriftVariance(drift, {.length = length, .turned = angle, .gap_sigma = gap}, unit));
  };
  EXPECT_NEAR(sigma(100, 1, 0, 0), 0.02, 1e-12);
  EXPECT_NEAR(sigma(10, 10, 0, 0), 0.02, 1e-12);
  EXPECT_NEAR(sigma(400, 1, 0, 0), 0.04, 1e-12);
  EXPECT_NEAR(sigma(0, 1, std::numbers::pi / 2, 0), 0.01, 1e-12);
  EXPECT_NEAR(sigma(0, 1, 0, 0.3), 0.3, 1e-12);
  EXPECT_NEAR(sigma(100, 1, 2 * std::numbers::pi, 0.03), std::sqrt(0.0004 + 0.0004 + 0.0009), 1e-12);
}

TEST(Drift, IsThatOfTheMapWhereThatIsMore) {
  const DriftOptions drift{0.02, 0.01};
  const auto variance = [&](double of_map, double gap) {
    return DriftVariance(drift, {.length = 100, .unit_variance = of_map, .gap_sigma = gap}, 1);
  };
  EXPECT_NEAR(variance(0.0003, 0), 0.0004, 1e-12);
  EXPECT_NEAR(variance(0.0009, 0), 0.0009, 1e-12);
  EXPECT_NEAR(variance(0.0009, 0.03), 0.0018, 1e-12);
}

TEST(Drift, RefusesSenselessValues) {
  const auto refused = [](auto change) { return RefusedField<DriftOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.per_100m = -0.1; }), "per_100m");
  EXPECT_EQ(refused([](auto& o) { o.per_90deg = 1; }), "per_90deg");
  EXPECT_EQ(refused([](auto& o) { o.unit_inflation = -1; }), "unit_inflation");
  EXPECT_EQ(refused([](auto& o) { o.unit_inflation = std::numeric_limits<double>::infinity(); }), "unit_inflation");
  EXPECT_EQ(refused([](auto& o) { o.unit_inflation = 0; }), "");
}

}  // namespace
}  // namespace turnscale
