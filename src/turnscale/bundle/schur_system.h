// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_structure.h"
#include "turnscale/bundle/normal_equations.h"

namespace turnscale {

/// What is left of the normal equations once the points are eliminated: S step = -gradient in the camera columns.
template <int kDof>
struct SchurSystem {
  std::vector<Eigen::Matrix<double, kDof, kDof>> blocks;  ///< as BundleStructure::blocks
  Eigen::VectorXd gradient;                               ///< kDof entries per column
  Eigen::VectorXd damping;                                ///< what was added to the cameras' diagonal
  std::vector<Eigen::Matrix3d> inverse_factor;            ///< of each point's damped Hessian V: V^-1 = F^T F
  std::vector<Eigen::Vector3d> point_damping;             ///< what was added to the points' diagonal
  std::vector<Eigen::Matrix<double, kDof, 3>> track;      ///< scratch: one point's edges times F^T
};

/// Adds `damping` times the diagonal (which makes the result independent of the unit of length) and eliminates the
/// points. Directions of a point that nothing determines stay put. Linear in the observations, quadratic in the number
/// of cameras that see one point.
template <int kDof>
void Eliminate(const BundleStructure& structure, const NormalEquations<kDof>& equations, double damping,
               SchurSystem<kDof>& system);

/// Adds M to the blocks of two cameras as [M -M; -M M], in the unknowns of their centres. `between` is their block
/// above the diagonal, -1 where one is fixed.
template <int kDof>
void AddToPair(const BundleStructure& structure, const DistanceConstraint& pair, int between, const Eigen::Matrix3d& M,
               SchurSystem<kDof>& system);

/// Steps of all points for a step of the cameras.
template <int kDof>
void BackSubstitute(const BundleStructure& structure, const NormalEquations<kDof>& equations,
                    const SchurSystem<kDof>& system, const Eigen::VectorXd& camera_step,
                    std::vector<Eigen::Vector3d>& point_step);

}  // namespace turnscale
