// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// A pose at a time (seconds).
struct StampedPose {
  double time = 0;
  RigidTransform world_from_camera;
};

/// Poses in the order of time; each holds the body's (by default the camera's) pose in one world frame.
using Trajectory = std::vector<StampedPose>;

}  // namespace turnscale
