// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/odometry/metric_path.h"

namespace turnscale {

/// Writes a map as binary PLY: landmarks in light gray, keyframe cameras in red, in the frame that `target_from_world`
/// leads to. Throws as OutputFile does.
void WriteMap(const std::filesystem::path& path, const MapPoints& points, const RigidTransform& target_from_world = {});

}  // namespace turnscale
