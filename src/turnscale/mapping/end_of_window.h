// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/geometry/similarity.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// The change of scale at the end of keyframes that have been adjusted, from their centres: lengths of their last
/// steps, over at least a few mean steps, so that standstill does not count. Empty where there is no motion, or where
/// the keyframes have shrunk or grown beyond what an adjustment does.
std::optional<double> ScaleOfEnd(const std::vector<Eigen::Vector3d>& before, const std::vector<Eigen::Vector3d>& after);

/// From the world before the adjustment to the world after it, so that the last camera sees the same.
Similarity MoveOfEnd(const RigidTransform& old_camera, const RigidTransform& new_camera, double scale);

/// The pose of a camera that moves with the world.
RigidTransform Moved(const RigidTransform& camera_from_world, const Similarity& new_from_old);

/// Moves keyframes from `first` on, and the valid landmarks that they see but for `others`, which are in ascending
/// order.
void MoveFrom(int first, const Similarity& new_from_old, const std::vector<int>& others, Map& map);

}  // namespace turnscale
