// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Length of a path up to each of its points, by straight lines between them; `position` gives that of a point.
template <class Path, class Position>
std::vector<double> LengthsAlong(const Path& path, const Position& position) {
  std::vector<double> lengths(path.size());
  for (std::size_t i = 1; i < path.size(); ++i)
    lengths[i] = lengths[i - 1] + (position(path[i]) - position(path[i - 1])).norm();
  return lengths;
}

inline std::vector<double> LengthsAlong(const Trajectory& path) {
  return LengthsAlong(
      path, [](const StampedPose& pose) -> const Eigen::Vector3d& { return pose.world_from_camera.translation; });
}

}  // namespace turnscale
