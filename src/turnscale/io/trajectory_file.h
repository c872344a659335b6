// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/geometry/trajectory.h"

namespace turnscale {

enum class TrajectoryFormat {
  kTum,    ///< `time tx ty tz qx qy qz qw`
  kKitti,  ///< 12 numbers: row-major 3x4 world_from_camera; or 13 with the frame's number first
};

struct TrajectoryFile {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  /// KITTI poses without `times` carry their frame's number as time.
  Trajectory poses;
  /// Number of each pose's frame: KITTI's first column or the line's number from 0; empty for TUM.
  std::vector<int> frames;
};

/// Reads a trajectory whose format is found from its columns; # begins a comment. `times` (seconds, by frame number)
/// are given to KITTI poses. Throws InputError that names file and line where a number is missing or NaN, a rotation is
/// none, times or frames do not increase, or `times` do not fit.
TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path,
                                  const std::optional<std::vector<double>>& times = std::nullopt);

/// The poses of ReadTrajectoryFile.
Trajectory ReadTrajectory(const std::filesystem::path& path,
                          const std::optional<std::vector<double>>& times = std::nullopt);

/// One line of a file, with its line end.
std::string TumLine(const StampedPose& pose);
std::string KittiLine(const RigidTransform& world_from_camera);

}  // namespace turnscale
