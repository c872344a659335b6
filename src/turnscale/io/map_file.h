// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "turnscale/mapping/map.h"

namespace turnscale {

/// Writes the map as binary PLY: valid landmarks in light gray, keyframe cameras in red, positions in metres (or the
/// map's unit) in the frame that `target_from_world` leads to. Throws as OutputFile does.
void WriteMap(const std::filesystem::path& path, const Map& map, const RigidTransform& target_from_world = {});

}  // namespace turnscale
