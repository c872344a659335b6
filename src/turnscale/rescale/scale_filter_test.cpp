// SPDX-License-Identifier: MIT
#include "turnscale/rescale/scale_filter.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

constexpr double kLeverArm = 1.1;
const ScaleNoise kNoise{{0.03, 0.001}, 0.01, 0.02};

std::vector<SwayStep> RandomSteps(Random& random, int count) {
  std::vector<SwayStep> steps;
  for (int i = 0; i < count; ++i) {
    SwayStep step;
    step.psi = 0.05 * (1 + random.Gaussian());
    step.length = 0.05 + 0.02 * random.Uniform();
    step.speed = 0.5 * random.Uniform();
    step.roll = 0.002 * random.Gaussian();
    const double scale = 18;
    step.sway = (kLeverArm - 0.004 * std::pow(scale * step.speed, 2)) * 2 * std::sin(step.psi / 2) / scale +
                0.004 * step.length + 1.5 * step.roll / scale + 3e-4 * random.Gaussian();
    steps.push_back(step);
  }
  return steps;
}

ScaleProblem RandomProblem(int stretches) {
  Random random(77);
  ScaleProblem problem;
  problem.lever_arm = kLeverArm;
  problem.prior.mean << std::log(18.0), 0, 0.0045, 1.5;
  problem.prior.covariance.diagonal() << 4, 1e-4, 2.25e-6, 1;
  for (int i = 0; i < stretches; ++i) {
    StretchObservation observation;
    observation.pooled = PoolSway(RandomSteps(random, 20), Eigen::Vector4d::Zero(), 3e-4, 1e9);
    observation.turning = i % 3 != 1;
    observation.distance = i > 0 ? 2 + random.Uniform() : 0;
    observation.angle = i > 0 ? random.Uniform() : 0;
    observation.lever_weight = 0.5 + random.Uniform();
    problem.observations.push_back(observation);
  }
  return problem;
}

std::vector<DriveState> Linearisation(const ScaleProblem& problem) {
  std::vector<DriveState> at(problem.observations.size(), problem.prior.mean);
  for (std::size_t i = 0; i < at.size(); ++i) at[i][kLogScale] += 0.01 * static_cast<double>(i % 4);
  return at;
}

double WalkVariance(const StretchObservation& observation, double scale) {
  return kNoise.per_distance * kNoise.per_distance * observation.distance * scale / 100 +
         kNoise.per_angle * kNoise.per_angle * observation.angle / (std::numbers::pi / 2);
}

// The same linearised problem as one dense least squares: a log-scale for each stretch, then travel, slip and height.
struct Dense {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};
Dense SolveDense(const ScaleProblem& problem, const std::vector<DriveState>& at) {
  const auto n = static_cast<Eigen::Index>(at.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n + 3, n + 3);
  Eigen::VectorXd target = Eigen::VectorXd::Zero(n + 3);
  const auto places = [&](Eigen::Index i) { return std::array<Eigen::Index, 4>{i, n, n + 1, n + 2}; };
  const auto add = [&](Eigen::Index i, const Eigen::Matrix4d& H, const Eigen::Vector4d& b) {
    const auto place = places(i);
    for (int r = 0; r < 4; ++r) {
      target[place[r]] += b[r];
      for (int c = 0; c < 4; ++c) information(place[r], place[c]) += H(r, c);
    }
  };
  const Eigen::Matrix4d prior = problem.prior.covariance.inverse();
  add(0, prior, prior * problem.prior.mean);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ScaleEvidence evidence = EvidenceAt(problem.observations[i], at[i], problem.lever_arm, kNoise.stretch);
    add(i, evidence.information, evidence.gradient + evidence.information * at[i]);
    if (i == 0) continue;
    const double w = 1 / WalkVariance(problem.observations[i], std::exp(at[i][kLogScale]));
    information(i, i) += w;
    information(i - 1, i - 1) += w;
    information(i, i - 1) -= w;
    information(i - 1, i) -= w;
  }
  const Eigen::MatrixXd covariance = information.inverse();
  return {covariance * target, covariance};
}

TEST(ScaleFilter, SmootherIsTheDenseLeastSquares) {
  const ScaleProblem problem = RandomProblem(12);
  const std::vector<DriveState> at = Linearisation(problem);
  const Dense dense = SolveDense(problem, at);
  const ScaleHistory history = SmoothScale(problem, kNoise, at);
  for (Eigen::Index i = 0; i < 12; ++i) {
    const Belief& belief = history.beliefs[i];
    EXPECT_NEAR(belief.mean[kLogScale], dense.mean[i], 1e-9);
    EXPECT_NEAR(belief.mean[kTravel], dense.mean[12], 1e-9);
    EXPECT_NEAR(belief.mean[kSlip], dense.mean[13], 1e-9);
    EXPECT_NEAR(belief.mean[kHeight], dense.mean[14], 1e-7);
    EXPECT_NEAR(belief.covariance(kLogScale, kLogScale) / dense.covariance(i, i), 1, 1e-6);
    EXPECT_NEAR(belief.covariance(kLogScale, kSlip) / dense.covariance(i, 13), 1, 1e-5);
  }
}

TEST(ScaleFilter, FilterEndsWhereTheSmootherDoes) {
  const ScaleProblem problem = RandomProblem(9);
  std::vector<DriveState> at = Linearisation(problem);
  ScaleHistory smoothed;
  for (int i = 0; i < 20; ++i) {
    smoothed = SmoothScale(problem, kNoise, at);
    EXPECT_EQ(smoothed.log_likelihood, ScaleLogLikelihood(problem, kNoise, at));
    for (std::size_t k = 0; k < at.size(); ++k) at[k] = smoothed.beliefs[k].mean;
  }
  const ScaleHistory filtered = FilterScale(problem, kNoise);
  const double sigma = std::sqrt(smoothed.beliefs.back().covariance(kLogScale, kLogScale));
  EXPECT_NEAR(filtered.beliefs.back().mean[kLogScale], smoothed.beliefs.back().mean[kLogScale], 0.1 * sigma)
      << "what each linearised elsewhere is all the difference";
  EXPECT_LT(smoothed.beliefs[3].covariance(kLogScale, kLogScale), filtered.beliefs[3].covariance(kLogScale, kLogScale));
}

TEST(ScaleFilter, AGapForgetsTheScaleBeforeIt) {
  ScaleProblem problem = RandomProblem(10);
  const std::vector<DriveState> at = Linearisation(problem);
  const ScaleHistory whole = SmoothScale(problem, kNoise, at);
  problem.observations[5].gap_sigma = 0.3;
  const ScaleHistory broken = SmoothScale(problem, kNoise, at);
  EXPECT_GT(broken.beliefs[4].covariance(kLogScale, kLogScale), whole.beliefs[4].covariance(kLogScale, kLogScale));
  EXPECT_GT(broken.beliefs[5].covariance(kLogScale, kLogScale), whole.beliefs[5].covariance(kLogScale, kLogScale));
}

TEST(ScaleFilter, FilterDoesNotSeeTheFuture) {
  const ScaleProblem whole = RandomProblem(10);
  ScaleProblem start = whole;
  start.observations.resize(6);
  const ScaleHistory a = FilterScale(whole, kNoise);
  const ScaleHistory b = FilterScale(start, kNoise);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(a.beliefs[i].mean, b.beliefs[i].mean);
}

}  // namespace
}  // namespace turnscale
