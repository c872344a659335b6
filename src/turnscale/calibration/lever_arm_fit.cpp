// SPDX-License-Identifier: MIT
#include "turnscale/calibration/lever_arm_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/calibration/lever_arm_equation.h"
#include "turnscale/calibration/lever_arm_errors.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/vehicle_step.h"

namespace turnscale {
namespace {

// This share of the residuals, of all steps and of the turning ones, is below the robust weight's threshold.
constexpr double kHuberShare = 0.6;
// Least turning of all drives together, rad.
constexpr double kLeastTurn = 30 / kDegreesPerRadian;
// Least LeverArmFit::speed_spread from which c can be told from L.
constexpr double kLeastSpeedSpread = 0.25;

std::vector<LeverArmEquation> Equations(const std::vector<MetricDrive>& drives) {
  std::vector<LeverArmEquation> equations;
  for (size_t drive = 0; drive < drives.size(); ++drive) {
    for (const CameraStep& step : drives[drive].steps) {
      const VehicleStep level = LevelStep(step.previous_from_current, drives[drive].vehicle_from_camera,
                                          (step.end - step.begin) / step.frames, {});
      // The whole step's turning and way, so that steps of more frames count for more.
      LeverArmEquation equation;
      equation.turn = step.frames * level.swing();
      equation.way = std::copysign(step.frames * level.motion.step, level.forward());
      equation.speed = std::copysign(level.speed(), level.forward());
      equation.roll = step.frames * level.roll;
      equation.sideways = step.frames * level.lateral() - kUsualRollHeight * equation.roll;
      equation.begin = step.begin;
      equation.end = step.end;
      equation.drive = static_cast<int>(drive);
      equations.push_back(equation);
    }
  }
  return equations;
}

// How well the turns' speeds separate L from c.
double SpeedSpread(const std::vector<LeverArmEquation>& equations) {
  double weight = 0;
  double mean = 0;
  for (const LeverArmEquation& equation : equations) {
    if (!equation.turning()) continue;
    weight += equation.turn * equation.turn;
    mean += equation.turn * equation.turn * equation.speed * equation.speed;
  }
  if (!(mean > 0)) return 0;
  mean /= weight;
  double variance = 0;
  for (const LeverArmEquation& equation : equations) {
    if (!equation.turning()) continue;
    const double off = equation.speed * equation.speed - mean;
    variance += equation.turn * equation.turn * off * off / weight;
  }
  return std::sqrt(variance) / mean;
}

// Robust least squares. Unknowns: L, the yaw of each drive, then c where it is fitted. Pseudo-Huber weights: they are
// nearly Huber's, and no step is without curvature, so that sigma does not hang on the few steps below the threshold.
class Fit {
 public:
  Fit(const std::vector<LeverArmEquation>& equations, int drives, bool side_slip, double assumed_side_slip)
      : side_slip_(side_slip),
        assumed_side_slip_(assumed_side_slip),
        unknowns_(1 + drives + (side_slip ? 1 : 0)),
        x_(Eigen::VectorXd::Zero(unknowns_)) {
    constexpr int kIterations = 30;
    double threshold = 1e9;
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      Eigen::VectorXd gradient = Eigen::VectorXd::Zero(unknowns_);
      hessian_ = Regular();
      for (const LeverArmEquation& equation : equations) {
        const Eigen::VectorXd row = Row(equation);
        const double off = Residual(equation);
        const double weight = Weight(off, threshold);
        hessian_ += weight * row * row.transpose();
        gradient += weight * off * row;
      }
      x_ += hessian_.ldlt().solve(gradient);
      threshold = Threshold(equations);
    }
    hessian_ = Regular();
    for (const LeverArmEquation& equation : equations) {
      const double off = Residual(equation);
      const double weight = Weight(off, threshold);
      fitted_.push_back({equation, Row(equation), weight * off, weight * weight * weight});
      hessian_ += fitted_.back().curvature * fitted_.back().row * fitted_.back().row.transpose();
    }
    covariance_ = CovarianceOfFit(fitted_, hessian_, drives, lever_arm());
  }

  LeverArm lever_arm() const { return {x_[0], side_slip_ ? x_[unknowns_ - 1] : assumed_side_slip_}; }

  // Of the errors of L and c, which is assumed with this standard deviation unless it is fitted.
  Eigen::Matrix2d Covariance(double side_slip_sigma) const {
    const std::array<Eigen::Index, 2> both = {0, unknowns_ - 1};
    if (side_slip_) return covariance_(both, both);
    Eigen::VectorXd by_slip = Eigen::VectorXd::Zero(unknowns_);
    for (const FittedEquation& fitted : fitted_) by_slip += fitted.curvature * fitted.equation.slip() * fitted.row;
    const Eigen::Vector2d joint(-hessian_.ldlt().solve(by_slip)[0], 1);
    Eigen::Matrix2d covariance = side_slip_sigma * side_slip_sigma * joint * joint.transpose();
    covariance(0, 0) += covariance_(0, 0);
    return covariance;
  }

 private:
  // A drive without a step leaves its yaw open.
  Eigen::MatrixXd Regular() const { return 1e-12 * Eigen::MatrixXd::Identity(unknowns_, unknowns_); }

  Eigen::VectorXd Row(const LeverArmEquation& equation) const {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(unknowns_);
    row[0] = equation.turn;
    row[1 + equation.drive] = equation.way;
    if (side_slip_) row[unknowns_ - 1] = equation.slip();
    return row;
  }

  double Residual(const LeverArmEquation& equation) const {
    const double assumed = side_slip_ ? 0 : assumed_side_slip_ * equation.slip();
    return equation.sideways - assumed - Row(equation).dot(x_);
  }

  // The few steps of a single turn are closer to their own line than to that of another turn: they do not tell alone
  // which residuals are usual.
  double Threshold(const std::vector<LeverArmEquation>& equations) const {
    std::vector<double> all;
    std::vector<double> turning;
    for (const LeverArmEquation& equation : equations) {
      all.push_back(std::abs(Residual(equation)));
      if (equation.turning()) turning.push_back(all.back());
    }
    return std::max({Quantile(std::move(all), kHuberShare), Quantile(std::move(turning), kHuberShare), 1e-9});
  }

  static double Weight(double off, double threshold) { return 1 / std::hypot(1, off / threshold); }

  bool side_slip_;
  double assumed_side_slip_;
  Eigen::Index unknowns_;
  Eigen::VectorXd x_;
  Eigen::MatrixXd hessian_;
  std::vector<FittedEquation> fitted_;
  Eigen::MatrixXd covariance_;
};

void SetSigmas(const Eigen::Matrix2d& covariance, double intrinsics_sigma, LeverArmFit& fit) {
  const double of_intrinsics = intrinsics_sigma * fit.lever_arm.length;
  fit.sigma_length = std::hypot(std::sqrt(covariance(0, 0)), of_intrinsics);
  fit.sigma_side_slip = std::sqrt(covariance(1, 1));
  if (fit.sigma_side_slip > 0) fit.slip_correlation = covariance(0, 1) / (fit.sigma_length * fit.sigma_side_slip);
}

std::string Fixed(double value, int digits) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << value;
  return text.str();
}

// What would make the lever arm more certain: that of the largest part of its sigma.
std::string Remedy(const LeverArmFit& fit, const LeverArmFitOptions& options) {
  const double exact = fit.SigmaAtExactSlip();
  const double of_slip = std::sqrt(std::max(fit.sigma_length * fit.sigma_length - exact * exact, 0.0));
  const double of_intrinsics = options.intrinsics_sigma * fit.lever_arm.length;
  const double of_turns = std::sqrt(std::max(exact * exact - of_intrinsics * of_intrinsics, 0.0));
  if (of_intrinsics > std::max(of_turns, of_slip)) return "use a more accurate calibration of the camera";
  if (of_slip > of_turns) return "use a drive with slower street corners, or a more certain side slip";
  return "use a drive with more street corners";
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
                     Fixed(fit.sigma_length, 2) + " m; " + Remedy(fit, options));
  }
}

}  // namespace

void LeverArmFitOptions::Check() const {
  if (!(assumed_side_slip >= 0)) throw InputError("assumed_side_slip: must not be negative");
  if (!(assumed_side_slip_sigma >= 0)) throw InputError("assumed_side_slip_sigma: must not be negative");
  if (!(intrinsics_sigma >= 0)) throw InputError("intrinsics_sigma: must not be negative");
  if (!(max_relative_sigma > 0)) throw InputError("max_relative_sigma: must be above 0");
}

LeverArmFit FitLeverArm(const std::vector<MetricDrive>& drives, const LeverArmFitOptions& options) {
  options.Check();
  const std::vector<LeverArmEquation> equations = Equations(drives);
  LeverArmFit fit;
  double turned = 0;
  for (const LeverArmEquation& equation : equations) {
    if (!equation.turning()) continue;
    turned += std::abs(equation.turn);
    ++fit.turning_steps;
  }
  if (turned < kLeastTurn) throw InputError("no turn: the lever arm is observable in turns only");
  fit.speed_spread = SpeedSpread(equations);
  if (options.side_slip && fit.speed_spread < kLeastSpeedSpread) {
    throw InputError(
        "the side slip is indistinguishable from the lever arm: all turns have about the same speed (v^2 "
        "spreads by " +
        Fixed(100 * fit.speed_spread, 0) + " %, " + Fixed(100 * kLeastSpeedSpread, 0) +
        " % are needed); give the side slip");
  }
  const int count = static_cast<int>(drives.size());
  const Fit line(equations, count, options.side_slip, options.assumed_side_slip);
  fit.lever_arm = line.lever_arm();
  fit.slip_fitted = options.side_slip;
  if (fit.lever_arm.side_slip < 0) {
    fit.slip_at_bound = true;
    fit.lever_arm = Fit(equations, count, false, 0).lever_arm();
  }
  // With c at its bound, the sigmas are those of the fit without it: c is not exact.
  SetSigmas(line.Covariance(options.assumed_side_slip_sigma), options.intrinsics_sigma, fit);
  CheckFit(fit, options);
  return fit;
}

}  // namespace turnscale
