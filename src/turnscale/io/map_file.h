// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/io/output_file.h"
#include "turnscale/odometry/metric_path.h"

namespace turnscale {

/// Writes a map as binary PLY: landmarks in light gray, keyframe cameras in red, transformed by `target_from_world`.
/// Throws as OutputFile does.
void WriteMap(const std::filesystem::path& path, const MapPoints& points, const RigidTransform& target_from_world = {},
              Durability durability = Durability::kPowerCut);

}  // namespace turnscale
