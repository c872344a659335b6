// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <vector>

#include "turnscale/kinematics/step_height.h"

namespace turnscale {

/// Relative standard deviation of a height whose file has none.
constexpr double kUsualHeightSigma = 0.02;

/// Reads heights of a camera above the road: a CSV file with the columns `time`, `height` and, where it is known,
/// `sigma` (the height's standard deviation, in the height's unit). Throws InputError that names file and line where a
/// number is missing, a height or sigma is not positive, or times do not grow, and for a file without a height.
std::vector<PathHeight> ReadHeightFile(const std::filesystem::path& path);

}  // namespace turnscale
