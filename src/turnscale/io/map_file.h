// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/odometry/metric_path.h"

namespace turnscale {

/// A map as binary PLY: landmarks in light gray, keyframe cameras in red, in the frame that `target_from_world` leads
/// to.
std::string MapText(const MapPoints& points, const RigidTransform& target_from_world = {});

}  // namespace turnscale
