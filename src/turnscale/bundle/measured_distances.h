// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/bundle/bundle_structure.h"
#include "turnscale/bundle/normal_equations.h"
#include "turnscale/bundle/schur_system.h"

namespace turnscale {

/// Half the sum of the squared errors, in sigmas.
double MeasuredDistanceCost(const std::vector<MeasuredDistance>& measured, const std::vector<Eigen::Vector3d>& centres);

/// Adds their cost and its gradient at a state to the normal equations.
template <int kDof>
void AddMeasuredDistances(const BundleProblem& problem, const BundleStructure& structure, const BundleState& state,
                          NormalEquations<kDof>& equations);

/// Adds their Hessian at a state to the reduced system; it has no part in the points.
template <int kDof>
void AddMeasuredDistances(const BundleProblem& problem, const BundleStructure& structure, const BundleState& state,
                          HessianKind kind, SchurSystem<kDof>& system);

}  // namespace turnscale
