// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/bundle/bundle_structure.h"
#include "turnscale/bundle/camera_distances.h"
#include "turnscale/bundle/camera_solver.h"
#include "turnscale/bundle/normal_equations.h"
#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// Step of all unknowns from the damped quadratic model under the linearised constraints.
struct KktStep {
  Eigen::VectorXd cameras;  ///< by column, (phi, delta) or delta
  std::vector<Eigen::Vector3d> points;
  Eigen::VectorXd multipliers;    ///< one per constraint
  double predicted_decrease = 0;  ///< of the cost by the undamped model
};

/// Constraint gradients, one column each, by the camera unknowns.
template <int kDof>
ConstraintMatrix ConstraintGradients(const BundleProblem& problem, const BundleStructure& structure,
                                     const std::vector<LinearizedDistance>& constraints);

/// Adds the constraints' share of the Lagrangian's Hessian (29) to a Schur system.
template <int kDof>
void AddConstraintCurvature(const BundleProblem& problem, const BundleStructure& structure,
                            const std::vector<LinearizedDistance>& constraints, const Eigen::VectorXd& multipliers,
                            SchurSystem<kDof>& system);

/// Solves [H D^T; D 0] [step; multipliers] = [-gradient; -share * values] with the points eliminated: the step removes
/// that share of the constraints' error. False where the reduced matrix is not positive definite along the constraints.
template <int kDof>
bool SolveKkt(const BundleProblem& problem, const BundleStructure& structure, const NormalEquations<kDof>& equations,
              const std::vector<LinearizedDistance>& constraints, const ConstraintMatrix& constraint_gradients,
              double share, SchurSystem<kDof>& system, CameraSolver<kDof>& solver, KktStep& step);

/// Largest entry of the Lagrangian's gradient, each over the square root of its Hessian's diagonal entry: how far one
/// unknown is from its best value, the others held, in units of its own standard deviation. Residuals are in sigmas, so
/// the number has no unit; it changes neither with the unit of length nor with the number of observations.
template <int kDof>
double KktResidual(const NormalEquations<kDof>& equations, const ConstraintMatrix& constraint_gradients,
                   const Eigen::VectorXd& multipliers);

/// Takes a step from `state` to `trial` and returns the observations' cost there.
///
/// The quadratic model can be far off for single points (tracks with outliers, points that hardly move in the image)
/// while it holds for all others. Such a point would spoil the whole step, so it is treated on its own: where a point's
/// cost rises, or where its model was rough, it is minimised with the cameras held at their new places. Near the
/// solution no point needs this and the step is the model's own. Infinite where a point is left behind a camera.
template <int kDof>
double TakeStep(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
                const NormalEquations<kDof>& equations, const KktStep& step, double huber_threshold,
                BundleState& trial);

}  // namespace turnscale
