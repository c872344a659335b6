// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/kinematics/vehicle_step.h"

namespace turnscale {

/// State of a scale that is not known, in a summary.
inline constexpr std::string_view kPendingScale = "pending";

/// The scale in the summary of the run that a trajectory is a result of; null if it is of none.
nlohmann::json ScaleOfRun(const std::filesystem::path& trajectory);

/// Its state; empty if there is none.
std::string ScaleStateOfRun(const std::filesystem::path& trajectory);

/// Time stamp of the first frame of its drive, from which printed times count, seconds; nothing if the summary does not
/// say, as that of an earlier version, or if the trajectory has no times of its own.
std::optional<double> FirstTimeOfRun(const std::filesystem::path& trajectory);

/// Length of the refined path as the run states it, along its keyframes, in the unit of the trajectory; nothing if the
/// trajectory is of none, or the online one.
std::optional<double> PathLengthOfRun(const std::filesystem::path& trajectory);

/// Whether a trajectory is a result of `run --frame vehicle`, in metres: its poses are the rear axle's.
bool IsOfRearAxle(const std::filesystem::path& trajectory);

/// The poses of a trajectory without those where tracking was lost, and where the map began anew.
struct MeasuredPath {
  Trajectory poses;
  std::vector<PathGap> gaps;
  int left_out = 0;  ///< poses that were interpolated or predicted
};

/// Of the refined trajectory of a run, by the states of the frames in the table beside it and the restarts in its
/// summary (any loss may be one where it lists none); all poses, and no gap, of any other.
MeasuredPath MeasuredPartOf(const std::filesystem::path& trajectory, const Trajectory& poses);

}  // namespace turnscale
