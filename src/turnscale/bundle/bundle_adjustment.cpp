// SPDX-License-Identifier: MIT
#include "turnscale/bundle/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "turnscale/base/error.h"
#include "turnscale/bundle/kkt_step.h"
#include "turnscale/bundle/trial.h"

namespace turnscale {
namespace {

/// Constraints count as met below this.
constexpr double kConstraintTolerance = 1e-10;
/// Differences of the cost below this share of it are rounding.
constexpr double kRounding = 1e-12;
constexpr double kSmallestDamping = 1e-12;
constexpr double kLargestDamping = 1e8;
/// The exact Hessian takes over once a step gains less than this share of the cost.
constexpr double kNewtonBelow = 1e-2;

/// How steps are judged: cost plus penalties * |constraints|, which falls along every SQP step when each penalty
/// exceeds its multiplier.
struct Merit {
  Eigen::VectorXd penalties;

  double Infeasibility(const BundleProblem& problem, const BundleState& state) const {
    double sum = 0;
    for (std::size_t i = 0; i < problem.distances.size(); ++i) {
      sum += penalties[static_cast<Eigen::Index>(i)] * std::abs(DistanceError(problem.distances[i], state.centres));
    }
    return sum;
  }

  void Cover(const Eigen::VectorXd& multipliers) {
    const Eigen::VectorXd sizes = multipliers.cwiseAbs();
    penalties = (2.0 * sizes).cwiseMax(0.5 * (penalties + sizes));
  }
};

double ConstraintResidual(const BundleProblem& problem, const BundleState& state) {
  double largest = 0;
  for (const DistanceConstraint& held : problem.distances) {
    largest = std::max(largest, std::abs(DistanceError(held, state.centres)));
  }
  return largest;
}

std::vector<LinearizedDistance> LinearizeConstraints(const BundleProblem& problem, const BundleState& state) {
  std::vector<LinearizedDistance> constraints;
  for (const DistanceConstraint& held : problem.distances) {
    constraints.push_back(LinearizeDistance(held, state.centres));
  }
  return constraints;
}

void RequireSeparateCentres(const BundleProblem& problem, const BundleState& state) {
  for (std::size_t i = 0; i < problem.distances.size(); ++i) {
    if (DistanceError(problem.distances[i], state.centres) <= -1.0) {
      throw InputError("bundle problem: distances[" + std::to_string(i) +
                       "] is between two cameras at the same place; which way to part them is unknown");
    }
  }
}

template <int kDof>
BundleSummary Adjust(const BundleOptions& options, BundleProblem& problem) {
  BundleState state = StateFromProblem(problem);
  RequireSeparateCentres(problem, state);
  const BundleStructure structure = MakeStructure(problem, state);
  CameraSolver<kDof> solver(static_cast<int>(structure.camera_of_column.size()), structure.blocks);
  NormalEquations<kDof> equations;
  SchurSystem<kDof> system;
  KktStep step;
  BundleState trial;
  const Eigen::Index constraint_count = static_cast<Eigen::Index>(problem.distances.size());
  Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(constraint_count);
  Merit merit{Eigen::VectorXd::Zero(constraint_count)};

  HessianKind kind = HessianKind::kGaussNewton;
  Linearize(problem.pinhole, structure, state, options.huber_threshold, kind, equations);
  BundleSummary summary;
  summary.initial_cost = equations.cost;
  double damping = std::max(options.initial_damping, kSmallestDamping);
  double raise = 2;
  for (;;) {
    const std::vector<LinearizedDistance> constraints = LinearizeConstraints(problem, state);
    const Eigen::MatrixXd gradients = ConstraintGradients<kDof>(problem, structure, constraints);
    summary.kkt_residual = KktResidual(equations, gradients, multipliers);
    summary.constraint_residual = ConstraintResidual(problem, state);
    const bool feasible = summary.constraint_residual < kConstraintTolerance;
    if (feasible && summary.kkt_residual < options.kkt_tolerance) {
      summary.converged = true;
      summary.message = "stationary";
      break;
    }
    bool accepted = false;
    double decrease = 0;
    while (!accepted && summary.iterations < options.max_iterations && damping < kLargestDamping) {
      ++summary.iterations;
      Eliminate(structure, equations, damping, system);
      if (kind == HessianKind::kNewton) {
        AddConstraintCurvature(problem, structure, constraints, multipliers, system);
      }
      double gain = -1;
      if (SolveKkt(problem, structure, equations, constraints, gradients, system, solver, step)) {
        merit.Cover(step.multipliers);
        const double before = merit.Infeasibility(problem, state);
        const double cost =
            TakeStep<kDof>(problem.pinhole, structure, state, step, 1.0, options.huber_threshold, trial);
        const double after = merit.Infeasibility(problem, trial);
        const double rounding = kRounding * equations.cost;
        decrease = equations.cost + before - cost - after;
        gain = (decrease + rounding) / (step.predicted_decrease + before + rounding);
        accepted = std::isfinite(cost) && gain > 1e-3;
      }
      if (accepted) {
        const double factor = 2.0 * std::min(gain, 1.0) - 1.0;
        damping = std::max(damping * std::max(0.1, 1.0 - factor * factor * factor), kSmallestDamping);
        raise = 2;
      } else {
        damping *= raise;
        raise *= 2;
      }
    }
    if (!accepted) {
      summary.message = damping < kLargestDamping ? "iteration limit" : "no step lowers the cost";
      break;
    }
    const double share = decrease / std::max(equations.cost, 1e-300);
    std::swap(state, trial);
    multipliers = step.multipliers;
    if (share < kNewtonBelow) kind = HessianKind::kNewton;
    Linearize(problem.pinhole, structure, state, options.huber_threshold, kind, equations);
    summary.final_cost = equations.cost;
    if (options.relative_cost_tolerance > 0 && share < options.relative_cost_tolerance &&
        ConstraintResidual(problem, state) < kConstraintTolerance) {
      summary.converged = true;
      summary.message = "cost settled";
      break;
    }
  }
  summary.final_cost = equations.cost;
  summary.constraint_residual = ConstraintResidual(problem, state);
  StateToProblem(state, options.fix_rotations, problem);
  return summary;
}

void Require(bool fine, const char* what) {
  if (!fine) throw InputError(std::string("bundle options: ") + what);
}

}  // namespace

void BundleOptions::Check() const {
  Require(max_iterations >= 0, "max_iterations is negative");
  Require(std::isfinite(huber_threshold) && huber_threshold >= 0, "huber_threshold is negative or not a number");
  Require(std::isfinite(relative_cost_tolerance) && relative_cost_tolerance >= 0,
          "relative_cost_tolerance is negative or not a number");
  Require(std::isfinite(kkt_tolerance) && kkt_tolerance >= 0, "kkt_tolerance is negative or not a number");
  Require(std::isfinite(initial_damping) && initial_damping >= 0, "initial_damping is negative or not a number");
}

BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem& problem) {
  options.Check();
  CheckProblem(problem);
  return options.fix_rotations ? Adjust<3>(options, problem) : Adjust<6>(options, problem);
}

}  // namespace turnscale
