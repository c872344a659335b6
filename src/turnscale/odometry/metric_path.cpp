// SPDX-License-Identifier: MIT
#include "turnscale/odometry/metric_path.h"

namespace turnscale {

RigidTransform MetricPath::InMetres(const Map& map, int keyframe, const RigidTransform& world_from_camera) const {
  return {world_from_camera.rotation, InMetres(map, keyframe, world_from_camera.translation)};
}

Eigen::Vector3d MetricPath::InMetres(const Map& map, int keyframe, const Eigen::Vector3d& point) const {
  return centres[keyframe] + metres_per_unit[keyframe] * (point - Centre(map.keyframes[keyframe]));
}

}  // namespace turnscale
