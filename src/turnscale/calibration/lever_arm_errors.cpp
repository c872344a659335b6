// SPDX-License-Identifier: MIT
#include "turnscale/calibration/lever_arm_errors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>

#include "turnscale/kinematics/turn_errors.h"

namespace turnscale {
namespace {

using FittedEquations = std::vector<FittedEquation>;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

double Middle(const FittedEquation& fitted) { return 0.5 * (fitted.equation.begin + fitted.equation.end); }

double Velocity(const FittedEquation& fitted) { return fitted.off / fitted.equation.duration(); }

double CorrelationOver(double seconds) { return std::exp(-seconds / kCommonSeconds); }

Matrix OuterSquare(const Vector& score) { return score * score.transpose(); }

// Of the scores of one drive.
Matrix OfMotion(const FittedEquations& equations, const MotionNoise& noise) {
  const Eigen::Index unknowns = equations.front().row.size();
  Matrix sum = Matrix::Zero(unknowns, unknowns);
  // Scores of the steps before, each with its correlation with the present one.
  Vector before = Vector::Zero(unknowns);
  double last = Middle(equations.front());
  for (const FittedEquation& fitted : equations) {
    before *= CorrelationOver(Middle(fitted) - last);
    last = Middle(fitted);
    const Vector score = fitted.equation.duration() * fitted.row;
    const Matrix cross = noise.common_variance * score * before.transpose();
    sum += (noise.step_variance + noise.common_variance) * OuterSquare(score) + cross + cross.transpose();
    before += score;
  }
  return sum;
}

// What a turn or a straight does to the scores by each of its deviations, and the scores themselves.
struct SegmentScores {
  Vector length, slip, way, off;

  explicit SegmentScores(Eigen::Index unknowns)
      : length(Vector::Zero(unknowns)), slip(length), way(length), off(length) {}

  void Add(const FittedEquation& fitted) {
    length += fitted.curvature * fitted.equation.turn * fitted.row;
    slip += fitted.curvature * fitted.equation.slip() * fitted.row;
    way += fitted.curvature * fitted.equation.way * fitted.row;
    off += fitted.off * fitted.row;
  }

  Matrix Deviations(bool turning, const LeverArm& lever_arm) const {
    if (!turning) return OuterSquare(kStraightDirectionSigma * way);
    return OuterSquare(kTurnSigma * lever_arm.length * length) +
           OuterSquare(kTurnSlipSigma * lever_arm.side_slip * slip) + OuterSquare(kTurnDirectionSigma * way);
  }
};

struct SumsOverSegments {
  Matrix deviations;
  Matrix scatter;
  int turns = 0;
};

SumsOverSegments SumOverSegments(const FittedEquations& equations, const LeverArm& lever_arm) {
  const Eigen::Index unknowns = equations.front().row.size();
  const Matrix zero = Matrix::Zero(unknowns, unknowns);
  SumsOverSegments sums{zero, zero};
  SegmentScores segment(unknowns);
  for (std::size_t i = 0; i < equations.size(); ++i) {
    segment.Add(equations[i]);
    const LeverArmEquation& equation = equations[i].equation;
    if (i + 1 < equations.size() && AreOfOneSegment(equation, equations[i + 1].equation)) continue;
    sums.deviations += segment.Deviations(equation.turning(), lever_arm);
    sums.scatter += OuterSquare(segment.off);
    sums.turns += equation.turning() ? 1 : 0;
    segment = SegmentScores(unknowns);
  }
  return sums;
}

Matrix OfAllMotion(const FittedEquations& equations, int drives) {
  const Eigen::Index unknowns = equations.front().row.size();
  Matrix sum = Matrix::Zero(unknowns, unknowns);
  for (auto begin = equations.begin(); begin != equations.end();) {
    const auto end = std::find_if(begin, equations.end(), [&](const FittedEquation& fitted) {
      return fitted.equation.drive != begin->equation.drive;
    });
    const FittedEquations drive(begin, end);
    sum += OfMotion(drive, FindMotionNoise(drive, static_cast<double>(unknowns) / drives));
    begin = end;
  }
  return sum;
}

// With the correlations of `covariance`, and no standard deviation below the other's.
Matrix NoSmaller(const Matrix& covariance, const Matrix& other) {
  const Vector factor = (other.diagonal().array() / covariance.diagonal().array().max(1e-300)).max(1.0).sqrt().matrix();
  return factor.asDiagonal() * covariance * factor.asDiagonal();
}

}  // namespace

MotionNoise FindMotionNoise(const std::vector<FittedEquation>& equations, double unknowns) {
  constexpr double kFarthest = 1.5 * kCommonSeconds;
  double squares = 0;
  double seconds = 0;
  double products = 0;
  double weights = 0;
  for (std::size_t i = 0; i < equations.size(); ++i) {
    squares += Velocity(equations[i]) * Velocity(equations[i]);
    seconds += equations[i].equation.duration();
    for (std::size_t k = i + 1; k < equations.size(); ++k) {
      const double apart = Middle(equations[k]) - Middle(equations[i]);
      if (apart > kFarthest) break;
      products += CorrelationOver(apart) * Velocity(equations[i]) * Velocity(equations[k]);
      weights += CorrelationOver(apart) * CorrelationOver(apart);
    }
  }
  const double found = weights > 0 ? std::max(products / weights, 0.0) : 0.0;
  const auto steps = static_cast<double>(equations.size());
  // So many independent values the common part has, and one more as usual.
  const double values = seconds / (2 * kCommonSeconds);
  const double common =
      (values * found + kUsualCommonVelocity * kUsualCommonVelocity) / (std::max(values - unknowns, 0.0) + 1);
  return {std::max(squares / steps - found, 0.0) * steps / std::max(steps - unknowns, 1.0), common};
}

Eigen::MatrixXd CovarianceOfFit(const std::vector<FittedEquation>& equations, const Eigen::MatrixXd& hessian,
                                int drives, const LeverArm& lever_arm) {
  const Eigen::Index unknowns = equations.front().row.size();
  Matrix of_steps = Matrix::Zero(unknowns, unknowns);
  Vector of_roll = Vector::Zero(unknowns);
  for (const FittedEquation& fitted : equations) {
    of_steps += OuterSquare(fitted.off * fitted.row);
    of_roll += fitted.curvature * fitted.equation.roll * fitted.row;
  }
  const Matrix inverse = hessian.ldlt().solve(Matrix::Identity(unknowns, unknowns));
  const auto of_unknowns = [&](const Matrix& scores) -> Matrix { return inverse * scores * inverse; };
  const SumsOverSegments segments = SumOverSegments(equations, lever_arm);
  Matrix covariance = of_unknowns(OfAllMotion(equations, drives) + segments.deviations);
  covariance = NoSmaller(covariance, of_unknowns(of_steps));
  const auto free = segments.turns - static_cast<int>(unknowns - drives);
  if (free > 0)
    covariance = NoSmaller(covariance, of_unknowns(static_cast<double>(segments.turns) / free * segments.scatter));
  return covariance + of_unknowns(OuterSquare(kUsualRollHeightSigma * of_roll));
}

}  // namespace turnscale
