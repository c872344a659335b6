// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace turnscale {

/// Closed outlines of what stands on the ground, (x, z) in metres, in the frame of a drive's poses.
using FloorPlan = std::vector<std::vector<Eigen::Vector2d>>;

/// `floor_plan.csv`: one corner per line, with the number of its outline.
std::string FloorPlanText(const FloorPlan& plan);

/// Throws InputError that names file and line where there is no such corner.
FloorPlan ReadFloorPlan(const std::filesystem::path& path);

}  // namespace turnscale
