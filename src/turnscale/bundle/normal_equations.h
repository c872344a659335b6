// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/bundle/bundle_structure.h"
#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// What a part of the points adds to the model in the cameras' unknowns, by column.
template <int kDof>
struct CameraSums {
  std::vector<Eigen::Matrix<double, kDof, kDof>> hessian;
  std::vector<Eigen::Matrix<double, kDof, 1>> gradient;
};

/// Quadratic model of the cost at a state, in blocks. Camera unknowns are (phi, delta) per column, with the centre
/// going to c - delta (see ObservationModel); kDof = 3 leaves phi out.
template <int kDof>
struct NormalEquations {
  using CameraMatrix = Eigen::Matrix<double, kDof, kDof>;
  using CameraVector = Eigen::Matrix<double, kDof, 1>;
  using EdgeMatrix = Eigen::Matrix<double, kDof, 3>;

  std::vector<CameraMatrix> camera_hessian;   ///< by column
  std::vector<CameraVector> camera_gradient;  ///< by column
  std::vector<EdgeMatrix> edge_hessian;       ///< camera rows, point columns; by edge
  std::vector<Eigen::Matrix3d> point_hessian;
  std::vector<Eigen::Vector3d> point_gradient;
  std::vector<double> point_cost;
  std::vector<char> point_is_rough;  ///< the exact Hessian was wanted, but the point got Gauss-Newton's
  double cost = 0;
  std::vector<CameraSums<kDof>> parts;  ///< scratch
};

enum class HessianKind {
  kGaussNewton,  ///< positive semidefinite everywhere
  kNewton,       ///< exact, but Gauss-Newton for points whose own exact block is not safely positive
};

template <int kDof>
void Linearize(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
               double huber_threshold, HessianKind kind, NormalEquations<kDof>& equations);

/// What the elimination of a part of the points subtracts from the camera blocks.
template <int kDof>
struct SchurPart {
  std::vector<Eigen::Matrix<double, kDof, kDof>> blocks;  ///< as BundleStructure::blocks
  Eigen::VectorXd gradient;
  std::vector<Eigen::Matrix<double, kDof, 3>> track;  ///< scratch: one point's edges times F^T
};

/// What is left of the normal equations once the points are eliminated: S step = -gradient in the camera columns.
template <int kDof>
struct SchurSystem {
  std::vector<Eigen::Matrix<double, kDof, kDof>> blocks;  ///< as BundleStructure::blocks
  Eigen::VectorXd gradient;                               ///< kDof entries per column
  Eigen::VectorXd damping;                                ///< what was added to the cameras' diagonal
  std::vector<Eigen::Matrix3d> inverse_factor;            ///< of each point's damped Hessian V: V^-1 = F^T F
  std::vector<Eigen::Vector3d> point_damping;             ///< what was added to the points' diagonal
  std::vector<SchurPart<kDof>> parts;                     ///< scratch
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
