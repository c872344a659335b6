// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// Metric positions of the keyframes beside a map that keeps its own unit: one entry per keyframe.
struct MetricPath {
  std::vector<Eigen::Vector3d> centres;  ///< metres; in the map's unit while the scale is pending
  std::vector<double> metres_per_unit;   ///< 1 while the scale is pending

  /// A camera pose near keyframe `keyframe` of the map, in metres.
  RigidTransform InMetres(const Map& map, int keyframe, const RigidTransform& world_from_camera) const;
  /// A point near that keyframe, in metres.
  Eigen::Vector3d InMetres(const Map& map, int keyframe, const Eigen::Vector3d& point) const;
};

}  // namespace turnscale
