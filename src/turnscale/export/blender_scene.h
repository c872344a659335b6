// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/run/result_folder.h"

namespace turnscale {

/// glTF 2.0 in one file, for Blender and others: a camera that is animated along the drive, the path as a line, and
/// landmarks (at most `most_landmarks`) as points. Lengths are metres, or the map's unit while the scale is pending; z
/// up becomes glTF's y up, the first pose looks along -z. `horizontal_fov` (rad) and `aspect` are the camera's. Throws
/// InputError if the run has no path.
std::string BlenderScene(const ResultFolder& results, const std::string& name, double horizontal_fov, double aspect,
                         int most_landmarks = 100000);

}  // namespace turnscale
