// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// A known point and where a frame saw it.
struct PointSighting {
  Eigen::Vector3d x_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
};

struct PoseEstimationOptions {
  /// Reprojection errors up to this many pixels count as agreement.
  double inlier_threshold = 2.0;
  /// Errors beyond this many pixels weigh linearly (Huber).
  double huber_threshold = 0.8;
  /// If fewer of the sightings agree, by their weights, the pose is fitted anew with these weights, as a vehicle ahead
  /// may have most of the sightings; what more of the image agrees with is taken.
  double min_agreeing_share = 0.8;
  /// Largest sum of the weights of the sightings in one cell of the image (CellWeights).
  double max_cell_weight = 2;
  int max_iterations = 10;  ///< of each of the rounds of refitting to the inliers

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

struct PoseEstimate {
  RigidTransform camera_from_world;
  std::vector<char> inlier;  ///< one flag per sighting
  int inliers = 0;
  double inlier_weight = 0;  ///< sum of the weights of the inliers
  double inlier_share = 0;   ///< the same as a share of the weights of all sightings
};

/// The camera pose that reprojects the points best: Gauss-Newton with a robust loss, refitted to the inliers a few
/// times, each round from the last pose, so that a wrong match loses its influence. Starts at `initial`. All sightings
/// weigh alike unless too few agree (min_agreeing_share).
PoseEstimate EstimatePose(const PoseEstimationOptions& options, const Pinhole& pinhole,
                          const std::vector<PointSighting>& sightings, const RigidTransform& initial);

}  // namespace turnscale
