// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

enum class TrajectoryFormat {
  kTum,    ///< `time tx ty tz qx qy qz qw`
  kEuroc,  ///< CSV: `time [ns],px,py,pz,qw,qx,qy,qz`, more columns are passed over
  kKitti,  ///< 12 numbers: row-major 3x4 world_from_camera; or 13 with the frame's number first
};

struct TrajectoryFile {
  TrajectoryFormat format = TrajectoryFormat::kTum;
  /// KITTI poses without `times` carry their frame's number as time.
  Trajectory poses;
  /// Number of each pose's frame: KITTI's first column or the line's number from 0; empty for TUM and EuRoC.
  std::vector<int> frames;
};

/// Reads a trajectory whose format is found from its columns; # begins a comment. Times that cannot be
/// seconds are converted from the unit that they fit (SecondsPerUnit). `times` (seconds, by frame number)
/// are given to KITTI poses. Throws InputError that names file and line where a number is missing or NaN, a rotation is
/// none, times or frames do not increase, or `times` do not fit.
TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path,
                                  const std::optional<std::vector<double>>& times = std::nullopt);

/// The trajectory of a path that a user names: a file, or the folder of a run, which stands for its trajectory.tum.
/// Throws InputError where a folder has none.
std::filesystem::path TrajectoryOf(const std::filesystem::path& named);

/// The poses of ReadTrajectoryFile.
Trajectory ReadTrajectory(const std::filesystem::path& path,
                          const std::optional<std::vector<double>>& times = std::nullopt);

/// Where the times of KITTI poses stand: `times.txt` beside them, or where the benchmark keeps them (`poses/07.txt`,
/// `sequences/07/times.txt`). Empty where there is neither.
std::filesystem::path FindPoseTimes(const std::filesystem::path& kitti_poses);

/// The rotation that a quaternion of a file stands for, whose digits are few. Throws InputError that begins with
/// `where` and names the expected columns if its norm is far from 1.
Eigen::Quaterniond RotationFromFile(const Eigen::Quaterniond& read, const std::string& where, std::string_view columns);

/// x, y, z of the translation and x, y, z, w of the quaternion, as files have them: zeros without a sign.
std::array<double, 7> PoseNumbers(const RigidTransform& pose);

/// One line of a file, with its line end and no signed zeros; 17 digits give back every bit.
std::string TumLine(const StampedPose& pose);
std::string KittiLine(const RigidTransform& world_from_camera, int digits = 9);

}  // namespace turnscale
