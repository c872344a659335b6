// SPDX-License-Identifier: MIT
#include "turnscale/bundle/bundle_state.h"

#include <cstddef>

namespace turnscale {

BundleState StateFromProblem(const BundleProblem& problem) {
  BundleState state;
  state.rotations.reserve(problem.camera_from_world.size());
  state.centres.reserve(problem.camera_from_world.size());
  for (const RigidTransform& camera_from_world : problem.camera_from_world) {
    const Eigen::Matrix3d R = camera_from_world.rotation.normalized().toRotationMatrix();
    state.rotations.push_back(R);
    state.centres.push_back(-(R.transpose() * camera_from_world.translation));
  }
  state.points = problem.points;
  return state;
}

void StateToProblem(const BundleState& state, bool fix_rotations, BundleProblem& problem) {
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    if (problem.camera_is_fixed[i]) continue;
    RigidTransform& camera_from_world = problem.camera_from_world[i];
    camera_from_world.translation = -(state.rotations[i] * state.centres[i]);
    if (!fix_rotations) camera_from_world.rotation = Eigen::Quaterniond(state.rotations[i]).normalized();
  }
  problem.points = state.points;
}

}  // namespace turnscale
