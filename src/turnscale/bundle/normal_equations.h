// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_state.h"
#include "turnscale/bundle/bundle_structure.h"
#include "turnscale/geometry/pinhole.h"

namespace turnscale {

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
};

enum class HessianKind {
  kGaussNewton,  ///< positive semidefinite everywhere
  kNewton,       ///< exact, but Gauss-Newton for points whose own exact block is not safely positive
};

template <int kDof>
void Linearize(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
               double huber_threshold, HessianKind kind, NormalEquations<kDof>& equations);

}  // namespace turnscale
