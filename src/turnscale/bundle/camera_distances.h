// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/bundle/bundle_structure.h"
#include "turnscale/bundle/normal_equations.h"

namespace turnscale {

/// Constraint (28) in the form |c_a - c_b| / distance - 1 = 0: the same solutions as the difference of squares, free of
/// units, and linear in the scale, so that one Newton step removes a wrong scale of any size.
struct LinearizedDistance {
  double value = 0;                                     ///< |c_a - c_b| / distance - 1
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();   ///< by c_a; by c_b it is the negative
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();  ///< second derivative by c_a and by c_b; mixed: the negative
};

/// |c_a - c_b| / distance - 1.
double DistanceError(const DistanceConstraint& held, const std::vector<Eigen::Vector3d>& centres);

/// Largest |DistanceError|; 0 without constraints.
double LargestDistanceError(const std::vector<DistanceConstraint>& distances,
                            const std::vector<Eigen::Vector3d>& centres);

/// Throws NumericalError where a distance is held or measured between centres that coincide: the way to part them is
/// unknown.
void RequireSeparateCentres(const BundleProblem& problem, const std::vector<Eigen::Vector3d>& centres);

/// The centres must not coincide.
LinearizedDistance LinearizeDistance(const DistanceConstraint& held, const std::vector<Eigen::Vector3d>& centres);

/// Half the sum of the squared errors of measured distances, in sigmas.
double MeasuredDistanceCost(const std::vector<MeasuredDistance>& measured, const std::vector<Eigen::Vector3d>& centres);

/// Adds their cost and its gradient at a state to the normal equations.
template <int kDof>
void AddMeasuredDistances(const BundleProblem& problem, const BundleStructure& structure, const BundleState& state,
                          NormalEquations<kDof>& equations);

/// Adds their Hessian at a state to the reduced system; it has no part in the points.
template <int kDof>
void AddMeasuredDistances(const BundleProblem& problem, const BundleStructure& structure, const BundleState& state,
                          HessianKind kind, SchurSystem<kDof>& system);

/// How steps under constraints are judged: by the cost plus penalties * |constraints|. It falls along every step of
/// sequential quadratic programming as long as each penalty exceeds the constraint's multiplier.
class Merit {
 public:
  /// The distances have to outlive the merit.
  explicit Merit(const std::vector<DistanceConstraint>& distances);

  /// Makes each penalty twice its multiplier at least; penalties that are no longer needed sink by halves.
  void Cover(const Eigen::VectorXd& multipliers);

  /// Sum of penalty * |distance error|.
  double Violation(const std::vector<Eigen::Vector3d>& centres) const;

 private:
  const std::vector<DistanceConstraint>& distances_;
  Eigen::VectorXd penalties_;
};

}  // namespace turnscale
