// SPDX-License-Identifier: MIT
#include "turnscale/calibration/lever_arm_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/kinematics/turning_motion.h"

namespace turnscale {
namespace {

// Unknowns: L, c, then the yaw of each drive.
struct Equation {
  double swing = 0;  ///< 2 sin(psi/2)
  double slip = 0;   ///< -v^2 times that
  double way = 0;    ///< metres a frame
  double sideways = 0;
  int drive = 0;
  double weight = 1;
};

std::vector<Equation> Equations(const std::vector<MetricDrive>& drives) {
  std::vector<Equation> equations;
  for (size_t drive = 0; drive < drives.size(); ++drive) {
    for (const CameraStep& step : drives[drive].steps) {
      const TurningMotion motion = TurningMotionOf(step.previous_from_current, drives[drive].vehicle_from_camera);
      const double speed = motion.step * step.frames / (step.end - step.begin);
      // The whole step's turning and way, so that steps of more frames count for more.
      Equation equation;
      equation.swing = step.frames * 2 * std::sin(0.5 * motion.psi);
      equation.slip = -speed * speed * equation.swing;
      equation.way = step.frames * motion.step;
      equation.sideways = equation.way * std::sin(motion.theta - 0.5 * motion.psi);
      equation.drive = static_cast<int>(drive);
      equations.push_back(equation);
    }
  }
  return equations;
}

Eigen::VectorXd Row(const Equation& equation, Eigen::Index unknowns, bool side_slip) {
  Eigen::VectorXd row = Eigen::VectorXd::Zero(unknowns);
  row[0] = equation.swing;
  if (side_slip) row[1] = equation.slip;
  row[(side_slip ? 2 : 1) + equation.drive] = equation.way;
  return row;
}

}  // namespace

void LeverArmFitOptions::Check() const {
  if (!(assumed_side_slip >= 0)) throw InputError("assumed_side_slip: must not be negative");
  if (!(huber_share > 0 && huber_share <= 1)) throw InputError("huber_share: must lie in (0, 1]");
  if (!(min_turn > 0)) throw InputError("min_turn: must be above 0 rad");
}

LeverArmFit FitLeverArm(const std::vector<MetricDrive>& drives, const LeverArmFitOptions& options) {
  options.Check();
  constexpr double kTurningStep = 2 / kDegreesPerRadian;
  constexpr int kIterations = 30;
  std::vector<Equation> equations = Equations(drives);
  LeverArmFit fit;
  double turned = 0;
  for (Equation& equation : equations) {
    if (std::abs(equation.swing) < kTurningStep) continue;
    turned += std::abs(equation.swing);
    ++fit.turning_steps;
  }
  if (turned < options.min_turn) throw InputError("no turn: the lever arm shows in turns only");
  const Eigen::Index first_yaw = options.side_slip ? 2 : 1;
  const Eigen::Index unknowns = first_yaw + static_cast<Eigen::Index>(drives.size());
  const auto residual = [&](const Equation& equation, const Eigen::VectorXd& row, const Eigen::VectorXd& x) {
    const double assumed = options.side_slip ? 0 : options.assumed_side_slip * equation.slip;
    return equation.sideways - assumed - row.dot(x);
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(unknowns);
  Eigen::MatrixXd hessian;
  Eigen::MatrixXd scores;
  for (int iteration = 0; iteration <= kIterations; ++iteration) {
    // A drive without a step leaves its yaw open.
    hessian = 1e-12 * Eigen::MatrixXd::Identity(unknowns, unknowns);
    scores = Eigen::MatrixXd::Zero(unknowns, unknowns);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unknowns);
    std::vector<double> sizes;
    for (const Equation& equation : equations) {
      const Eigen::VectorXd row = Row(equation, unknowns, options.side_slip);
      const double off = residual(equation, row, x);
      sizes.push_back(std::abs(off));
      const bool straight_part = iteration == kIterations && equation.weight < 1;
      if (!straight_part) hessian += equation.weight * row * row.transpose();
      gradient += equation.weight * off * row;
      scores += equation.weight * equation.weight * off * off * row * row.transpose();
    }
    if (iteration == kIterations) break;
    x += hessian.ldlt().solve(gradient);
    const double threshold = std::max(Quantile(sizes, options.huber_share), 1e-9);
    for (Equation& equation : equations) {
      const double off = std::abs(residual(equation, Row(equation, unknowns, options.side_slip), x));
      equation.weight = off > threshold ? threshold / off : 1;
    }
  }
  const Eigen::MatrixXd inverse = hessian.ldlt().solve(Eigen::MatrixXd::Identity(unknowns, unknowns));
  const Eigen::MatrixXd covariance = inverse * scores * inverse;
  fit.lever_arm.length = x[0];
  fit.sigma_length = std::sqrt(covariance(0, 0));
  fit.lever_arm.side_slip = options.side_slip ? x[1] : options.assumed_side_slip;
  if (options.side_slip) fit.sigma_side_slip = std::sqrt(covariance(1, 1));
  for (Eigen::Index i = first_yaw; i < unknowns; ++i) fit.yaw_correction.push_back(x[i]);
  return fit;
}

}  // namespace turnscale
