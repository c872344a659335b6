// SPDX-License-Identifier: MIT
#include "timed_trajectory.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/io/frame_times.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {

TimedTrajectory ReadTimedTrajectory(const std::filesystem::path& path,
                                    const std::optional<std::filesystem::path>& timestamps, std::optional<double> fps) {
  if (fps && !(std::isfinite(*fps) && *fps > 0)) {
    throw InputError(fmt::format("--fps {}: give frames per second, above 0", *fps));
  }
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (file.format != TrajectoryFormat::kKitti) {
    if (!fps && !timestamps) return {std::move(file.poses), true};
    throw InputError(fmt::format("{}: has timestamps; leave out {}", path.string(), fps ? "--fps" : "--timestamps"));
  }
  if (fps) {
    for (StampedPose& pose : file.poses) pose.time /= *fps;
    return {std::move(file.poses), true};
  }
  const std::filesystem::path times = timestamps ? *timestamps : FindPoseTimes(path);
  if (times.empty()) return {std::move(file.poses), false};
  return {ReadTrajectory(path, ReadFrameTimes(times).times), true};
}

}  // namespace turnscale
