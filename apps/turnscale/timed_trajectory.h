// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>

#include "turnscale/geometry/trajectory.h"

namespace turnscale {

struct TimedTrajectory {
  Trajectory poses;
  bool timed = true;  ///< else the poses carry their frames' numbers as times
};

/// Reads a trajectory with its times, seconds: its own (TUM, EuRoC), or for KITTI's poses those of `timestamps`, of so
/// many frames a second, or of the times.txt that FindPoseTimes finds. Throws InputError, also where times are given
/// for a file that has its own.
TimedTrajectory ReadTimedTrajectory(const std::filesystem::path& path,
                                    const std::optional<std::filesystem::path>& timestamps, std::optional<double> fps);

}  // namespace turnscale
