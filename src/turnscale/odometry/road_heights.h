// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// Height of the camera above the road at a keyframe. It is stored relative to the distance between the two keyframes
/// that show it, with its derivatives by their motion: when the map is adjusted, it changes with them.
struct MeasuredHeight {
  int keyframe = 0;
  int reference = 0;  ///< the earlier keyframe
  double ratio = 0;   ///< height over the distance between the two
  double sigma = 0;   ///< relative
  /// With which it was measured: the map's latest keyframe then, hardly adjusted.
  RigidTransform reference_from_keyframe;
  Eigen::RowVector3d by_rotation = Eigen::RowVector3d::Zero();   ///< of ln(ratio), as in RoadPlane
  Eigen::RowVector3d by_direction = Eigen::RowVector3d::Zero();  ///< of ln(ratio), as in RoadPlane
};

/// Sets the height of a step along the map's keyframes from those measured at its keyframes, in the map's present unit.
/// `heights` are in the order of their keyframes.
void SetStepHeight(const Map& map, const std::vector<MeasuredHeight>& heights, VehicleStep& step);

}  // namespace turnscale
