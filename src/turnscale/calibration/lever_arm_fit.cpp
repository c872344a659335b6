// SPDX-License-Identifier: MIT
#include "turnscale/calibration/lever_arm_fit.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/vehicle_step.h"

namespace turnscale {
namespace {

constexpr double kTurningStep = 2 / kDegreesPerRadian;

// Unknowns: L, the yaw of each drive, then c where it is fitted.
struct Equation {
  double turn = 0;      ///< 2 sin(psi/2)
  double speed = 0;     ///< m/s, negative in reverse
  double way = 0;       ///< metres, negative in reverse
  double sideways = 0;  ///< metres, without what the roll of the body adds
  double roll = 0;      ///< rad
  int drive = 0;

  bool turning() const { return std::abs(turn) >= kTurningStep; }
  double slip() const { return -speed * std::abs(speed) * turn; }
};

std::vector<Equation> Equations(const std::vector<MetricDrive>& drives) {
  std::vector<Equation> equations;
  for (size_t drive = 0; drive < drives.size(); ++drive) {
    for (const CameraStep& step : drives[drive].steps) {
      const VehicleStep level = LevelStep(step.previous_from_current, drives[drive].vehicle_from_camera,
                                          (step.end - step.begin) / step.frames, {});
      // The whole step's turning and way, so that steps of more frames count for more.
      Equation equation;
      equation.turn = step.frames * 2 * std::sin(0.5 * level.motion.psi);
      equation.way = std::copysign(step.frames * level.motion.step, level.forward());
      equation.speed = std::copysign(level.speed(), level.forward());
      equation.roll = step.frames * level.roll;
      equation.sideways = step.frames * level.lateral() - kUsualRollHeight * equation.roll;
      equation.drive = static_cast<int>(drive);
      equations.push_back(equation);
    }
  }
  return equations;
}

// How well the turns' speeds separate L from c.
double SpeedSpread(const std::vector<Equation>& equations) {
  double weight = 0;
  double mean = 0;
  for (const Equation& equation : equations) {
    if (!equation.turning()) continue;
    weight += equation.turn * equation.turn;
    mean += equation.turn * equation.turn * equation.speed * equation.speed;
  }
  if (!(mean > 0)) return 0;
  mean /= weight;
  double variance = 0;
  for (const Equation& equation : equations) {
    if (!equation.turning()) continue;
    const double off = equation.speed * equation.speed - mean;
    variance += equation.turn * equation.turn * off * off / weight;
  }
  return std::sqrt(variance) / mean;
}

// Robust least squares. Pseudo-Huber weights: they are nearly Huber's, and no step is without curvature, so that sigma
// does not hang on the few steps below the threshold.
class Fit {
 public:
  Fit(const std::vector<Equation>& equations, int drives, bool side_slip, double assumed_side_slip, double huber_share)
      : equations_(equations),
        side_slip_(side_slip),
        assumed_side_slip_(assumed_side_slip),
        unknowns_(1 + drives + (side_slip ? 1 : 0)),
        x_(Eigen::VectorXd::Zero(unknowns_)) {
    constexpr int kIterations = 30;
    double threshold = 1e9;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      // A drive without a step leaves its yaw open.
      Eigen::MatrixXd hessian = 1e-12 * Eigen::MatrixXd::Identity(unknowns_, unknowns_);
      Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unknowns_);
      for (const Equation& equation : equations_) {
        const Eigen::VectorXd row = Row(equation);
        const double off = Residual(equation);
        const double weight = Weight(off, threshold);
        hessian += weight * row * row.transpose();
        gradient += weight * off * row;
      }
      x_ += hessian.ldlt().solve(gradient);
      std::vector<double> sizes;
      for (const Equation& equation : equations_) {
        if (equation.turning()) sizes.push_back(std::abs(Residual(equation)));
      }
      threshold = std::max(Quantile(std::move(sizes), huber_share), 1e-9);
    }
    Sandwich(threshold);
  }

  double length() const { return x_[0]; }
  double side_slip() const { return side_slip_ ? x_[unknowns_ - 1] : assumed_side_slip_; }
  double sigma_length() const { return sigma_[0]; }
  double sigma_side_slip() const { return side_slip_ ? sigma_[unknowns_ - 1] : 0; }

 private:
  Eigen::VectorXd Row(const Equation& equation) const {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(unknowns_);
    row[0] = equation.turn;
    row[1 + equation.drive] = equation.way;
    if (side_slip_) row[unknowns_ - 1] = equation.slip();
    return row;
  }

  double Residual(const Equation& equation) const {
    const double assumed = side_slip_ ? 0 : assumed_side_slip_ * equation.slip();
    return equation.sideways - assumed - Row(equation).dot(x_);
  }

  static double Weight(double off, double threshold) { return 1 / std::hypot(1, off / threshold); }

  // Step by step, where all are independent, and turn by turn, where the steps of a turn (or of the way between two)
  // err together; the larger. The height above the roll axis errs in all turns alike.
  void Sandwich(double threshold) {
    Eigen::MatrixXd hessian = 1e-12 * Eigen::MatrixXd::Identity(unknowns_, unknowns_);
    Eigen::MatrixXd of_steps = Eigen::MatrixXd::Zero(unknowns_, unknowns_);
    Eigen::MatrixXd of_turns = of_steps;
    Eigen::VectorXd turn_score = Eigen::VectorXd::Zero(unknowns_);
    Eigen::VectorXd roll_score = Eigen::VectorXd::Zero(unknowns_);
    int turns = 0;
    for (size_t i = 0; i < equations_.size(); ++i) {
      const Equation& equation = equations_[i];
      const Eigen::VectorXd row = Row(equation);
      const double off = Residual(equation);
      const double weight = Weight(off, threshold);
      const double curvature = weight * weight * weight;
      hessian += curvature * row * row.transpose();
      roll_score += curvature * equation.roll * row;
      const Eigen::VectorXd score = weight * off * row;
      of_steps += score * score.transpose();
      turn_score += score;
      const bool last = i + 1 == equations_.size() || equations_[i + 1].drive != equation.drive ||
                        equations_[i + 1].turning() != equation.turning() ||
                        (equation.turning() && equations_[i + 1].turn * equation.turn < 0);
      if (!last) continue;
      of_turns += turn_score * turn_score.transpose();
      turn_score.setZero();
      turns += equation.turning() ? 1 : 0;
    }
    const int free = turns - (side_slip_ ? 2 : 1);
    if (free > 0) of_turns *= static_cast<double>(turns) / free;
    const Eigen::MatrixXd inverse = hessian.ldlt().solve(Eigen::MatrixXd::Identity(unknowns_, unknowns_));
    sigma_ = (inverse * of_steps * inverse).diagonal();
    if (free > 0) sigma_ = sigma_.cwiseMax(Eigen::VectorXd((inverse * of_turns * inverse).diagonal()));
    sigma_ += (kUsualRollHeightSigma * (inverse * roll_score)).cwiseAbs2();
    sigma_ = sigma_.cwiseMax(0).cwiseSqrt().eval();
  }

  const std::vector<Equation>& equations_;
  bool side_slip_;
  double assumed_side_slip_;
  Eigen::Index unknowns_;
  Eigen::VectorXd x_;
  Eigen::VectorXd sigma_;
};

std::string Fixed(double value, int digits) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << value;
  return text.str();
}

// Throws InputError where the fit is not valid.
void CheckFit(const LeverArmFit& fit, const LeverArmFitOptions& options) {
  const double length = fit.lever_arm.length;
  if (!(length > 0)) {
    throw InputError("the estimated lever arm is " + Fixed(length, 2) +
                     " m, but the camera must be ahead of the rear axle; check " + options.source_of_metres +
                     " and the side slip");
  }
  if (length > kLongestLeverArm) {
    throw InputError("the estimated lever arm is " + Fixed(length, 1) + " m, above the " + Fixed(kLongestLeverArm, 0) +
                     " m that a car can have; check " + options.source_of_metres);
  }
  if (!(fit.sigma_length <= options.max_relative_sigma * length)) {
    throw InputError("the estimated lever arm is too uncertain, " + Fixed(length, 2) + " +- " +
                     Fixed(fit.sigma_length, 2) + " m; use a drive with more street corners");
  }
}

}  // namespace

void LeverArmFitOptions::Check() const {
  if (!(assumed_side_slip >= 0)) throw InputError("assumed_side_slip: must not be negative");
  if (!(huber_share > 0 && huber_share <= 1)) throw InputError("huber_share: must lie in (0, 1]");
  if (!(min_turn > 0)) throw InputError("min_turn: must be above 0 rad");
  if (!(min_speed_spread >= 0)) throw InputError("min_speed_spread: must not be negative");
  if (!(max_relative_sigma > 0)) throw InputError("max_relative_sigma: must be above 0");
}

LeverArmFit FitLeverArm(const std::vector<MetricDrive>& drives, const LeverArmFitOptions& options) {
  options.Check();
  const std::vector<Equation> equations = Equations(drives);
  LeverArmFit fit;
  double turned = 0;
  for (const Equation& equation : equations) {
    if (!equation.turning()) continue;
    turned += std::abs(equation.turn);
    ++fit.turning_steps;
  }
  if (turned < options.min_turn) throw InputError("no turn: the lever arm is observable in turns only");
  fit.speed_spread = SpeedSpread(equations);
  if (options.side_slip && fit.speed_spread < options.min_speed_spread) {
    throw InputError(
        "the side slip is indistinguishable from the lever arm: all turns have about the same speed (v^2 "
        "spreads by " +
        Fixed(100 * fit.speed_spread, 0) + " %, " + Fixed(100 * options.min_speed_spread, 0) +
        " % are needed); give the side slip");
  }
  const int count = static_cast<int>(drives.size());
  std::optional<Fit> line(std::in_place, equations, count, options.side_slip, options.assumed_side_slip,
                          options.huber_share);
  if (options.side_slip && line->side_slip() < 0) {
    fit.slip_at_bound = true;
    line.emplace(equations, count, false, 0, options.huber_share);
  }
  fit.lever_arm = {line->length(), line->side_slip()};
  fit.sigma_length = line->sigma_length();
  fit.sigma_side_slip = line->sigma_side_slip();
  CheckFit(fit, options);
  return fit;
}

}  // namespace turnscale
