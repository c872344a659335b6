// SPDX-License-Identifier: MIT
#include "turnscale/calibration/lever_arm_errors.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

constexpr double kStepSeconds = 0.6;

// Of a straight drive at 10 m/s, with this noise of the sideways velocity, m/s.
std::vector<FittedEquation> NoisySteps(int steps, double of_step, double common, int seed) {
  Random random(static_cast<std::uint64_t>(seed));
  const double kept = std::exp(-kStepSeconds / kCommonSeconds);
  double velocity = common * random.Gaussian();
  std::vector<FittedEquation> equations;
  for (int i = 0; i < steps; ++i) {
    LeverArmEquation equation;
    equation.begin = kStepSeconds * i;
    equation.end = equation.begin + kStepSeconds;
    equation.way = 10 * kStepSeconds;
    const double off = kStepSeconds * (velocity + of_step * random.Gaussian());
    equations.push_back({equation, Eigen::Vector2d(0, equation.way), off, 1});
    velocity = kept * velocity + std::sqrt(1 - kept * kept) * common * random.Gaussian();
  }
  return equations;
}

TEST(MotionNoise, TellsWhatIsCommonFromWhatIsNot) {
  const MotionNoise both = FindMotionNoise(NoisySteps(5000, 0.05, 0.08, 1), 2);
  EXPECT_NEAR(std::sqrt(both.step_variance), 0.05, 0.01);
  EXPECT_NEAR(std::sqrt(both.common_variance), 0.08, 0.008);
  const MotionNoise white = FindMotionNoise(NoisySteps(5000, 0.05, 0, 2), 2);
  EXPECT_NEAR(std::sqrt(white.step_variance), 0.05, 0.002);
  EXPECT_LT(std::sqrt(white.common_variance), 0.01);
}

TEST(MotionNoise, AShortDriveDoesNotShowThatThereIsNone) {
  const MotionNoise brief = FindMotionNoise(NoisySteps(6, 0, 0, 1), 2);
  EXPECT_NEAR(std::sqrt(brief.common_variance), kUsualCommonVelocity, 1e-9);
  const MotionNoise lasting = FindMotionNoise(NoisySteps(600, 0, 0, 1), 2);
  EXPECT_LT(std::sqrt(lasting.common_variance), 0.2 * kUsualCommonVelocity);
}

TEST(MotionNoise, AFitTakesErrorsOfAShortDriveWithIt) {
  constexpr int kRuns = 400;
  double variance = 0;
  double as_of_nothing_fitted = 0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<FittedEquation> equations = NoisySteps(40, 0.02, 0.08, 100 + run);
    // A mean and a slope.
    Eigen::MatrixXd rows(equations.size(), 2);
    Eigen::VectorXd off(equations.size());
    for (Eigen::Index i = 0; i < off.size(); ++i) {
      rows.row(i) << 1, static_cast<double>(i);
      off[i] = equations[i].off;
    }
    off -= rows * (rows.transpose() * rows).ldlt().solve(rows.transpose() * off);
    for (Eigen::Index i = 0; i < off.size(); ++i) equations[i].off = off[i];
    variance += FindMotionNoise(equations, 2).common_variance / kRuns;
    as_of_nothing_fitted += FindMotionNoise(equations, 0).common_variance / kRuns;
  }
  EXPECT_LT(std::sqrt(as_of_nothing_fitted), 0.054);
  EXPECT_GT(std::sqrt(variance), 0.058);
  EXPECT_LT(std::sqrt(variance), 0.08);
}

TEST(CovarianceOfFit, IsThatOfTheMeanOfCorrelatedErrors) {
  constexpr int kRuns = 300;
  constexpr int kSteps = 200;
  double squares = 0;
  double stated = 0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<FittedEquation> equations = NoisySteps(kSteps, 0.02, 0.08, 1000 + run);
    double yaw = 0;
    for (const FittedEquation& fitted : equations) yaw += fitted.off / fitted.equation.way / kSteps;
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(1, 1);
    for (FittedEquation& fitted : equations) {
      fitted.row = Eigen::VectorXd::Constant(1, fitted.equation.way);
      fitted.off -= yaw * fitted.equation.way;
      hessian += fitted.curvature * fitted.row * fitted.row.transpose();
    }
    squares += yaw * yaw / kRuns;
    stated += CovarianceOfFit(equations, hessian, 1, {})(0, 0) / kRuns;
  }
  EXPECT_NEAR(std::sqrt(stated / (squares + std::pow(0.1 / kDegreesPerRadian, 2))), 1, 0.1)
      << "the noise, and the crown of the one straight";
}

}  // namespace
}  // namespace turnscale
