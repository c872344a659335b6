// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "turnscale/bundle/bundle_problem.h"

namespace turnscale {

struct BundleOptions {
  int max_iterations = 20;
  /// Residuals (in sigmas) beyond this weigh linearly, not quadratically (Huber); 0 gives plain least squares.
  double huber_threshold = 2.0;
  /// Rotations stay as they are, only camera centres and points move: the absolute scale recovery's problem (26).
  bool fix_rotations = false;
  /// Stop when the cost falls by less than this share in an accepted step and the constraints are met.
  double relative_cost_tolerance = 1e-6;
  /// Stop when the KKT residual (see BundleSummary) is below this.
  double kkt_tolerance = 1e-10;
  /// First damping, relative to the diagonal of the normal equations, so that the result does not depend on the unit of
  /// length.
  double initial_damping = 1e-4;
  /// Near the solution, use the exact Hessian (Newton steps), and linearise at the result for its KKT residual; with
  /// constraints always. Otherwise all steps are Gauss-Newton's, and the last one is not followed by a linearisation:
  /// for windows that are adjusted again later.
  bool use_exact_hessian = true;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

struct BundleSummary {
  int iterations = 0;
  bool converged = false;
  double initial_cost = 0;  ///< half the sum of robustified squared residuals, in sigmas squared
  double final_cost = 0;
  /// Largest entry of the Lagrangian's gradient (29), each in standard deviations of its own unknown (KktResidual in
  /// kkt_step.h). Without BundleOptions::use_exact_hessian, that before the last step.
  double kkt_residual = 0;
  /// Largest |(distance between the centres) / distance - 1| over the constraints.
  double constraint_residual = 0;
  std::string message;  ///< why it ended, in words
};

/// Levenberg-Marquardt on cameras and points with the points eliminated (Schur complement); where there are distance
/// constraints, sequential quadratic programming on the same normal equations (24)-(30). Far from the solution steps
/// are Gauss-Newton's, near it they use the exact Hessian of the Lagrangian, so that the end is quadratic.
///
/// Cost per iteration is linear in points and observations. Deterministic, and independent of the unit of length.
/// Observations whose point starts behind their camera are left out; no other point ends behind a camera that sees it.
/// Throws as CheckProblem and BundleOptions::Check do, and NumericalError where cameras with a held or measured
/// distance coincide.
BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem& problem);

/// AdjustBundle for problems that a drive can do without: nothing where it throws NumericalError (a position that is no
/// number), and the problem is then left as it is.
std::optional<BundleSummary> TryAdjustBundle(const BundleOptions& options, BundleProblem& problem);

}  // namespace turnscale
