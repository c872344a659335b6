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

/// Gauss-Newton or Newton steps under the linearised constraints, each taken if the merit falls by enough of what the
/// model promises.
template <int kDof>
class Adjustment {
 public:
  Adjustment(const BundleOptions& options, const BundleProblem& problem)
      : options_(options),
        problem_(problem),
        use_exact_hessian_(options.use_exact_hessian || !problem.distances.empty()),
        merit_(problem.distances),
        caution_{std::max(options.initial_damping, kSmallestDamping)} {
    at_.state = StateFromProblem(problem);
    at_.multipliers.setZero(static_cast<Eigen::Index>(problem.distances.size()));
    RequireSeparateCentres(problem, at_.state.centres);
    structure_ = MakeStructure(problem, at_.state);
  }

  BundleSummary Run() {
    Linearize();
    CameraSolver<kDof> solver(static_cast<int>(structure_.camera_of_column.size()), structure_.blocks,
                              at_.constraint_gradients);
    summary_.initial_cost = at_.equations.cost;
    while (!Assess()) {
      ++summary_.iterations;
      if (!FindStep(solver) || !TryStep()) BeMoreCautious();
    }
    if (structure_.behind_camera > 0) {
      summary_.message += "; left out " + std::to_string(structure_.behind_camera) + " observations behind a camera";
    }
    return summary_;
  }

  const BundleState& state() const { return at_.state; }

 private:
  void Linearize() {
    turnscale::Linearize(problem_.pinhole, structure_, at_.state, options_.huber_threshold, at_.kind, at_.equations);
    AddMeasuredDistances(problem_, structure_, at_.state, at_.equations);
    at_.constraints.clear();
    for (const DistanceConstraint& held : problem_.distances) {
      at_.constraints.push_back(LinearizeDistance(held, at_.state.centres));
    }
    at_.constraint_gradients = ConstraintGradients<kDof>(problem_, structure_, at_.constraints);
  }

  /// Brings the summary up to date. True where nothing is left to do, or no way leads on; the summary says which.
  bool Assess() {
    if (!summary_.message.empty()) return true;
    summary_.final_cost = at_.equations.cost;
    summary_.kkt_residual = KktResidual(at_.equations, at_.constraint_gradients, at_.multipliers);
    summary_.constraint_residual = LargestDistanceError(problem_.distances, at_.state.centres);
    const bool feasible = summary_.constraint_residual < kConstraintTolerance;
    const bool stationary = summary_.kkt_residual < options_.kkt_tolerance;
    summary_.converged = feasible && (stationary || settled_);
    if (summary_.converged) {
      summary_.message = stationary ? "stationary" : "cost settled";
    } else if (caution_.damping > kLargestDamping) {
      summary_.message = "no step lowers the cost";
    } else if (summary_.iterations == options_.max_iterations) {
      summary_.message = "iteration limit";
    }
    return !summary_.message.empty();
  }

  /// The next step. False where the model has none under the constraints.
  bool FindStep(CameraSolver<kDof>& solver) {
    Eliminate(structure_, at_.equations, caution_.damping, system_);
    AddMeasuredDistances(problem_, structure_, at_.state, at_.kind, system_);
    if (at_.kind == HessianKind::kNewton) {
      AddConstraintCurvature(problem_, structure_, at_.constraints, at_.multipliers, system_);
    }
    return SolveKkt(problem_, structure_, at_.equations, at_.constraints, at_.constraint_gradients,
                    caution_.constraint_share, system_, solver, step_);
  }

  /// Takes the step if it gains enough.
  bool TryStep() {
    merit_.Cover(step_.multipliers);
    const double cost =
        TakeStep(problem_.pinhole, structure_, at_.state, at_.equations, step_, options_.huber_threshold, trial_) +
        MeasuredDistanceCost(problem_.measured_distances, trial_.centres);
    const double violation = merit_.Violation(at_.state.centres);
    const double decrease = at_.equations.cost + violation - cost - merit_.Violation(trial_.centres);
    const double rounding = kCostRounding * at_.equations.cost;
    const double gain =
        (decrease + rounding) / (step_.predicted_decrease + caution_.constraint_share * violation + rounding);
    if (!std::isfinite(cost) || !(gain > kAcceptedGain)) return false;
    caution_.Relax(gain);
    std::swap(at_.state, trial_);
    at_.multipliers = step_.multipliers;
    if (use_exact_hessian_ && decrease < kNewtonBelow * at_.equations.cost) at_.kind = HessianKind::kNewton;
    settled_ = std::abs(decrease) < options_.relative_cost_tolerance * at_.equations.cost;
    if (!use_exact_hessian_ && (settled_ || summary_.iterations == options_.max_iterations)) {
      // The equations at the new place would only tell the residual.
      summary_.final_cost = cost;
      summary_.converged = settled_;
      summary_.message = settled_ ? "cost settled" : "iteration limit";
    } else {
      Linearize();
    }
    return true;
  }

  /// After a step that failed. The exact Hessian may have directions of negative curvature, and too far from the
  /// solution it leads astray.
  void BeMoreCautious() {
    caution_.Tighten();
    if (at_.kind == HessianKind::kGaussNewton) return;
    at_.kind = HessianKind::kGaussNewton;
    Linearize();
  }

  const BundleOptions& options_;
  const BundleProblem& problem_;
  const bool use_exact_hessian_;
  BundleStructure structure_;
  Iterate<kDof> at_;
  SchurSystem<kDof> system_;
  KktStep step_;
  BundleState trial_;
  Merit merit_;
  Caution caution_;
  bool settled_ = false;  // by the last step that was taken
  BundleSummary summary_;
};

template <int kDof>
BundleSummary Adjust(const BundleOptions& options, BundleProblem& problem) {
  Adjustment<kDof> adjustment(options, problem);
  BundleSummary summary = adjustment.Run();
  StateToProblem(adjustment.state(), options.fix_rotations, problem);
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
