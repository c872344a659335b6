// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>
#include <vector>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Whether the poses of a drive, in pieces that hang together, are those of the world in the camera's frame
/// (camera_from_world) rather than the other way round. A camera on a car goes along one axis of its own on all
/// straights; read the wrong way round, along another one on each. A single straight tells nothing.
bool AreInverse(const std::vector<Trajectory>& pieces);

/// What there is to say of such poses.
inline constexpr std::string_view kInversePoses =
    "the poses are camera_from_world: read as world_from_camera, the camera goes along no axis of its own, but along "
    "one if they are inverted; give the inverse poses";

}  // namespace turnscale
