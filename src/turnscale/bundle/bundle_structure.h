// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"

namespace turnscale {

/// One observation as the inner loops read it.
struct SolverObservation {
  Eigen::Vector2d pixel;
  double inverse_sigma;
  int camera;
  int edge;  ///< the point's edge to this camera; -1 where the camera is fixed
};

/// Who sees whom, worked out once: nothing of it changes during the adjustment.
///
/// A camera column is a free camera's place in the reduced system. An edge joins a point and a camera column (several
/// observations of one point by one camera share it). The reduced system is symmetric; its blocks are the diagonal ones
/// by column, then those above the diagonal, by row and column.
struct BundleStructure {
  std::vector<int> column_of_camera;            ///< -1 where the camera is fixed
  std::vector<int> camera_of_column;            ///< the free cameras
  std::vector<SolverObservation> observations;  ///< by point, then camera
  std::vector<int> first_observation;           ///< of each point; one more entry than points
  std::vector<int> edge_column;                 ///< by point, then column
  std::vector<int> first_edge;                  ///< of each point; one more entry than points
  std::vector<int> pair_block;                  ///< per point, per pair of edges i <= j: the block they fill
  std::vector<std::size_t> first_pair;          ///< of each point, into `pair_block`
  std::vector<std::array<int, 2>> blocks;       ///< (row, column), row <= column
  std::vector<int> distance_block;              ///< block above the diagonal of each distance; -1: one end is fixed
  std::vector<int> measured_distance_block;     ///< the same for the measured distances
  int longest_track = 0;                        ///< largest number of edges of a point
  int behind_camera = 0;                        ///< observations left out: their point starts behind the camera
};

/// An observation whose point is not in front of its camera at the start has no meaningful residual and is left out for
/// the whole adjustment.
BundleStructure MakeStructure(const BundleProblem& problem, const BundleState& state);

}  // namespace turnscale
