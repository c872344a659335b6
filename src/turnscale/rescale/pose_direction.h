// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Whether the poses of a drive, in pieces that hang together, are those of the world in the camera's frame
/// (camera_from_world) rather than the other way round. A camera on a car goes along one axis of its own all the time;
/// read the wrong way round, it goes along one of the world's, and in turns about the origin. A straight tells nothing.
bool AreInverse(const std::vector<Trajectory>& pieces);

}  // namespace turnscale
