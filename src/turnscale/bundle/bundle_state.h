// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"

namespace turnscale {

/// The unknowns as the solver holds them: x_in_camera = rotation * (x_in_world - centre).
struct BundleState {
  std::vector<Eigen::Matrix3d> rotations;  ///< camera_from_world, one per camera
  std::vector<Eigen::Vector3d> centres;    ///< optical centres in the world, one per camera
  std::vector<Eigen::Vector3d> points;     ///< in the world
};

BundleState StateFromProblem(const BundleProblem& problem);

/// Writes back the points and the free cameras; fixed cameras keep every bit, and so do the rotations where only the
/// centres were free.
void StateToProblem(const BundleState& state, bool fix_rotations, BundleProblem& problem);

}  // namespace turnscale
