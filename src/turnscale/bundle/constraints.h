// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"

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

}  // namespace turnscale
