// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// The unit of length at one pose of a path.
struct PoseScale {
  double metres_per_unit = 0;
  double sigma = 0;        ///< relative
  bool after_gap = false;  ///< reached across a loss of tracking
  bool from_road = false;  ///< no turn that is used, and the road shows the scale of the step that leads to the pose
};

/// The scale along a path, one entry per pose: interpolated along the length between the middles of segments, but not
/// across a gap. `steps` are those of the estimate, along the same poses.
std::vector<PoseScale> ScaleTrack(int poses, const std::vector<VehicleStep>& steps, const ScaleEstimate& estimate);

/// Positions in metres: each step from pose to pose is scaled by the mean of its ends' scales, one across a loss of
/// tracking by the scale before it, whose unit it was predicted in. The first position keeps its direction from the
/// origin.
std::vector<Eigen::Vector3d> MetricPositions(const std::vector<Eigen::Vector3d>& positions,
                                             const std::vector<PoseScale>& scales);

}  // namespace turnscale
