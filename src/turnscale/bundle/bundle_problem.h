// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Where a point was seen by a camera, in undistorted pixels.
struct BundleObservation {
  int camera = 0;
  int point = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma = 1;  ///< standard deviation of each pixel coordinate, pixels
};

/// Equality constraint (28): the centres of two cameras are `distance` apart.
struct DistanceConstraint {
  int camera_a = 0;
  int camera_b = 0;
  double distance = 0;
};

/// The same as a measurement instead of a constraint.
struct MeasuredDistance {
  DistanceConstraint between;
  double sigma = 0;  ///< standard deviation, relative to the distance
};

/// What bundle adjustment works on: cameras that share one pinhole, points, and what was seen of which.
struct BundleProblem {
  Pinhole pinhole;
  std::vector<RigidTransform> camera_from_world;
  std::vector<char> camera_is_fixed;    ///< one flag per camera; at least one camera has to be fixed
  std::vector<Eigen::Vector3d> points;  ///< in the world frame; all of them are free
  std::vector<BundleObservation> observations;
  std::vector<DistanceConstraint> distances;  ///< equality constraints (24)-(30); empty for plain bundle adjustment
  std::vector<MeasuredDistance> measured_distances;  ///< measurements; not robustified
};

/// Throws with the name of the entry: InternalError where sizes, indices, sigmas or distances in the problem make no
/// sense, NumericalError where the pinhole, a pose, a point or a pixel is not a number.
void CheckProblem(const BundleProblem& problem);

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
