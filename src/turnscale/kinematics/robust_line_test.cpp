// SPDX-License-Identifier: MIT
#include <cmath>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "turnscale/kinematics/pooled_line.h"

namespace turnscale {
namespace {

constexpr double kSlope = -0.7;
constexpr double kThreshold = 6;

std::vector<LinePoint> NoisyLine(int count, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<LinePoint> points;
  for (int i = 0; i < count; ++i) {
    const double x = normal(random);
    points.push_back({x, kSlope * x + sigma * normal(random)});
  }
  return points;
}

TEST(RobustLine, ExactOnAnExactLine) {
  const RobustLine line = FitRobustLine(NoisyLine(9, 0, 1), 0.01, kThreshold);
  EXPECT_NEAR(line.slope, kSlope, 1e-14);
  for (const double weight : line.weight) EXPECT_NEAR(weight, 1, 1e-12);
}

TEST(RobustLine, IsLeastSquaresWhereNothingIsFarOff) {
  const std::vector<LinePoint> points = NoisyLine(30, 0.1, 2);
  Eigen::MatrixXd x(points.size(), 1);
  Eigen::VectorXd y(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    x(i, 0) = points[i].x;
    y[i] = points[i].y;
  }
  const double slope = x.colPivHouseholderQr().solve(y)[0];
  const RobustLine line = FitRobustLine(points, 1e-6, 1e6);
  EXPECT_NEAR(line.slope, slope, 1e-8);
  const double residual = (y - x * slope).norm() / std::sqrt(static_cast<double>(points.size()) - 1);
  EXPECT_NEAR(line.sigma, residual / x.norm(), 1e-8);
}

TEST(RobustLine, StretchingBothAxesStretchesTheLine) {
  std::vector<LinePoint> points = NoisyLine(20, 0.1, 3);
  points[4].y += 3;
  const RobustLine before = FitRobustLine(points, 0.01, kThreshold);
  for (LinePoint& point : points) {
    point.x *= 4;
    point.y *= 100;
  }
  const RobustLine after = FitRobustLine(points, 1, kThreshold);
  EXPECT_NEAR(after.slope, 25 * before.slope, 1e-12);
  EXPECT_NEAR(after.sigma, 25 * before.sigma, 1e-12);
}

TEST(RobustLine, AThirdOfTheStepsMayBeAnything) {
  std::vector<LinePoint> points = NoisyLine(30, 0.02, 4);
  for (std::size_t i = 0; i < points.size(); i += 3) points[i].y = 5 + points[i].x;
  const RobustLine line = FitRobustLine(points, 0.01, kThreshold);
  EXPECT_NEAR(line.slope, kSlope, 0.005);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i % 3 == 0) {
      EXPECT_EQ(line.weight[i], 0);
    } else {
      EXPECT_GT(line.weight[i], 0.3);
    }
  }
}

TEST(RobustLine, SigmaIsTheSpreadOfTheSlope) {
  constexpr int kNoisyLines = 400;
  for (const int count : {8, 30}) {
    double squares = 0;
    double variance = 0;
    for (unsigned seed = 0; seed < kNoisyLines; ++seed) {
      // The same places each time: sigma is for given x.
      std::vector<LinePoint> points = NoisyLine(count, 0, 5);
      std::mt19937 random(seed);
      std::normal_distribution<double> normal(0, 0.1);
      for (LinePoint& point : points) point.y += normal(random);
      const RobustLine line = FitRobustLine(points, 1e-3, kThreshold);
      squares += std::pow(line.slope - kSlope, 2);
      variance += line.sigma * line.sigma;
    }
    EXPECT_NEAR(std::sqrt(variance / squares), 1, 0.12) << count;
  }
}

TEST(RobustLine, FewPointsAreNotBelievedToBeExact) {
  const std::vector<LinePoint> points{{1, kSlope}, {2, 2 * kSlope}};
  const RobustLine line = FitRobustLine(points, 0.3, kThreshold);
  EXPECT_NEAR(line.sigma, 0.3 / std::sqrt(5.0), 1e-12);
}

}  // namespace
}  // namespace turnscale
