// SPDX-License-Identifier: MIT
#include "turnscale/bundle/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "turnscale/base/error.h"
#include "turnscale/bundle/camera_distances.h"
#include "turnscale/bundle/kkt_step.h"

namespace turnscale {
namespace {

/// Constraints count as met below this.
constexpr double kConstraintTolerance = 1e-10;
/// Differences of the cost below this share of it are rounding.
constexpr double kCostRounding = 1e-12;
/// The exact Hessian takes over once a step gains less than this share of the cost. Gauss-Newton is the safer guide far
/// from the solution; close to it, with noise in the pixels, it converges only linearly.
constexpr double kNewtonBelow = 1e-2;
/// A step has to bring at least this share of what the model promises.
constexpr double kAcceptedGain = 1e-3;
constexpr double kSmallestDamping = 1e-12;
constexpr double kSmallestRaisedDamping = 1e-8;
constexpr double kLargestDamping = 1e8;

/// How far steps may go. The damping follows Nielsen: a good step lowers it smoothly, bad ones raise it ever faster.
/// Damping shortens no step that the constraints ask for, so after a bad step they are asked for a part of their error.
struct Caution {
  double damping = 0;
  double raise = 2;
  double constraint_share = 1;

  void Relax(double gain) {
    const double surplus = 2.0 * std::min(gain, 1.0) - 1.0;
    damping = std::max(damping * std::max(0.1, 1.0 - surplus * surplus * surplus), kSmallestDamping);
    raise = 2;
    constraint_share = std::min(1.0, 2.0 * constraint_share);
  }

  void Tighten() {
    damping = raise * std::max(damping, kSmallestRaisedDamping);
    raise *= 2;
    constraint_share *= 0.5;
  }
};

/// The adjustment's unknowns and everything known at their present values.
template <int kDof>
struct Iterate {
  BundleState state;
  HessianKind kind = HessianKind::kGaussNewton;
  NormalEquations<kDof> equations;
  std::vector<LinearizedDistance> constraints;
  ConstraintMatrix constraint_gradients;
  Eigen::VectorXd multipliers;
};

template <int kDof>
void Linearize(const BundleOptions& options, const BundleProblem& problem, const BundleStructure& structure,
               Iterate<kDof>& at) {
  Linearize(problem.pinhole, structure, at.state, options.huber_threshold, at.kind, at.equations);
  AddMeasuredDistances(problem, structure, at.state, at.equations);
  at.constraints.clear();
  for (const DistanceConstraint& held : problem.distances) {
    at.constraints.push_back(LinearizeDistance(held, at.state.centres));
  }
  at.constraint_gradients = ConstraintGradients<kDof>(problem, structure, at.constraints);
}

/// The exact Hessian may have directions of negative curvature, and too far from the solution it leads astray.
template <int kDof>
void BackToGaussNewton(const BundleOptions& options, const BundleProblem& problem, const BundleStructure& structure,
                       Iterate<kDof>& at) {
  if (at.kind == HessianKind::kGaussNewton) return;
  at.kind = HessianKind::kGaussNewton;
  Linearize(options, problem, structure, at);
}

template <int kDof>
BundleSummary Adjust(const BundleOptions& options, BundleProblem& problem) {
  Iterate<kDof> at;
  at.state = StateFromProblem(problem);
  at.multipliers.setZero(static_cast<Eigen::Index>(problem.distances.size()));
  RequireSeparateCentres(problem, at.state.centres);
  const BundleStructure structure = MakeStructure(problem, at.state);
  Linearize(options, problem, structure, at);

  CameraSolver<kDof> solver(static_cast<int>(structure.camera_of_column.size()), structure.blocks,
                            at.constraint_gradients);
  SchurSystem<kDof> system;
  KktStep step;
  BundleState trial;
  Merit merit(problem.distances);
  Caution caution{std::max(options.initial_damping, kSmallestDamping)};
  const bool use_exact_hessian = options.use_exact_hessian || !problem.distances.empty();
  BundleSummary summary;
  summary.initial_cost = at.equations.cost;
  bool settled = false;
  for (;;) {
    summary.final_cost = at.equations.cost;
    summary.kkt_residual = KktResidual(at.equations, at.constraint_gradients, at.multipliers);
    summary.constraint_residual = LargestDistanceError(problem.distances, at.state.centres);
    const bool feasible = summary.constraint_residual < kConstraintTolerance;
    const bool stationary = summary.kkt_residual < options.kkt_tolerance;
    summary.converged = feasible && (stationary || settled);
    if (summary.converged) {
      summary.message = stationary ? "stationary" : "cost settled";
      break;
    }
    if (summary.iterations == options.max_iterations || caution.damping > kLargestDamping) {
      summary.message = caution.damping > kLargestDamping ? "no step lowers the cost" : "iteration limit";
      break;
    }
    ++summary.iterations;

    Eliminate(structure, at.equations, caution.damping, system);
    AddMeasuredDistances(problem, structure, at.state, at.kind, system);
    if (at.kind == HessianKind::kNewton) {
      AddConstraintCurvature(problem, structure, at.constraints, at.multipliers, system);
    }
    if (!SolveKkt(problem, structure, at.equations, at.constraints, at.constraint_gradients, caution.constraint_share,
                  system, solver, step)) {
      caution.Tighten();
      BackToGaussNewton(options, problem, structure, at);
      continue;
    }
    merit.Cover(step.multipliers);
    const double cost =
        TakeStep(problem.pinhole, structure, at.state, at.equations, step, options.huber_threshold, trial) +
        MeasuredDistanceCost(problem.measured_distances, trial.centres);
    const double violation = merit.Violation(at.state.centres);
    const double decrease = at.equations.cost + violation - cost - merit.Violation(trial.centres);
    const double rounding = kCostRounding * at.equations.cost;
    const double gain =
        (decrease + rounding) / (step.predicted_decrease + caution.constraint_share * violation + rounding);
    if (!std::isfinite(cost) || !(gain > kAcceptedGain)) {
      caution.Tighten();
      BackToGaussNewton(options, problem, structure, at);
      continue;
    }
    caution.Relax(gain);
    std::swap(at.state, trial);
    at.multipliers = step.multipliers;
    if (use_exact_hessian && decrease < kNewtonBelow * at.equations.cost) at.kind = HessianKind::kNewton;
    settled = std::abs(decrease) < options.relative_cost_tolerance * at.equations.cost;
    if (!use_exact_hessian && (settled || summary.iterations == options.max_iterations)) {
      summary.final_cost = cost;
      summary.converged = settled;
      summary.message = settled ? "cost settled" : "iteration limit";
      break;
    }
    Linearize(options, problem, structure, at);
  }
  if (structure.behind_camera > 0) {
    summary.message += "; left out " + std::to_string(structure.behind_camera) + " observations behind a camera";
  }
  StateToProblem(at.state, options.fix_rotations, problem);
  return summary;
}

void RequireOption(bool fine, const char* what) {
  if (!fine) throw InputError(std::string("bundle options: ") + what);
}

}  // namespace

void BundleOptions::Check() const {
  RequireOption(max_iterations >= 0, "max_iterations is negative");
  RequireOption(std::isfinite(huber_threshold) && huber_threshold >= 0, "huber_threshold is negative or not a number");
  RequireOption(std::isfinite(relative_cost_tolerance) && relative_cost_tolerance >= 0,
                "relative_cost_tolerance is negative or not a number");
  RequireOption(std::isfinite(kkt_tolerance) && kkt_tolerance >= 0, "kkt_tolerance is negative or not a number");
  RequireOption(std::isfinite(initial_damping) && initial_damping >= 0, "initial_damping is negative or not a number");
}

BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem& problem) {
  options.Check();
  CheckProblem(problem);
  return options.fix_rotations ? Adjust<3>(options, problem) : Adjust<6>(options, problem);
}

std::optional<BundleSummary> TryAdjustBundle(const BundleOptions& options, BundleProblem& problem) {
  try {
    return AdjustBundle(options, problem);
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}

}  // namespace turnscale
