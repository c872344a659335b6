// SPDX-License-Identifier: MIT
#include "turnscale/commands/run_of_trajectory.h"

#include <fstream>
#include <string>
#include <system_error>

#include "turnscale/base/csv_table.h"
#include "turnscale/io/run_files.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

bool IsOfRun(const fs::path& trajectory) {
  const fs::path name = trajectory.filename();
  return name == RunFiles::kTrajectoryTum || name == RunFiles::kTrajectoryKitti || name == RunFiles::kLiveTum;
}

// A member of the summary; null if there is none.
nlohmann::json OfRun(const fs::path& trajectory, const char* member) {
  if (!IsOfRun(trajectory)) return {};
  std::ifstream file(trajectory.parent_path() / RunFiles::kSummary);
  const nlohmann::json summary = nlohmann::json::parse(file, nullptr, false);
  return summary.is_object() && summary.contains(member) ? summary[member] : nlohmann::json();
}

struct FrameState {
  double time = 0;
  bool lost = false;     // as FindMissingParts has it: a repeated image within a loss is part of it
  bool bridged = false;  // lost although there is an image
};

// Of the frames with a pose; empty if the file is not of a run.
std::vector<FrameState> StatesIn(const fs::path& file) {
  std::vector<FrameState> states;
  std::error_code none;
  if (!fs::exists(file, none)) return states;
  CsvTable table(file, "table of frames");
  for (const char* column : {"time", "state", "x"})
    if (!table.HasColumn(column)) return states;
  const auto time = table.Column("time");
  const auto state = table.Column("state");
  const auto x = table.Column("x");
  bool lost = false;
  while (table.Next()) {
    if (table.Text(x).empty()) continue;
    const std::string& name = table.Text(state);
    const auto is = [&](TrackingState one) { return name == TrackingStateName(one); };
    const bool bridged = is(TrackingState::kBridged);
    lost = bridged || is(TrackingState::kUnreadable) || (lost && is(TrackingState::kRepeated));
    states.push_back({table.Value<double>(time), lost, bridged});
  }
  return states;
}

}  // namespace

nlohmann::json ScaleOfRun(const fs::path& trajectory) { return OfRun(trajectory, "scale"); }

std::string ScaleStateOfRun(const fs::path& trajectory) {
  const nlohmann::json scale = ScaleOfRun(trajectory);
  return scale.contains("state") && scale["state"].is_string() ? scale["state"].get<std::string>() : "";
}

bool IsOfRearAxle(const fs::path& trajectory) {
  const std::string state = ScaleStateOfRun(trajectory);
  return !state.empty() && state != kPendingScale && OfRun(trajectory, "pose_frame") == "vehicle";
}

MeasuredPath MeasuredPartOf(const fs::path& trajectory, const Trajectory& poses) {
  const bool is_refined = IsOfRun(trajectory) && trajectory.filename() != RunFiles::kLiveTum;
  const std::vector<FrameState> states =
      is_refined ? StatesIn(trajectory.parent_path() / RunFiles::kTrajectoryTable) : std::vector<FrameState>();
  if (states.size() != poses.size()) return {poses, {}, 0};
  const TrackingOptions limits;
  MeasuredPath path;
  int bridged = 0;  // since the last measured pose
  double measured_time = 0;
  double bridged_time = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    const FrameState& state = states[i];
    if (state.lost) {
      ++path.left_out;
      if (!state.bridged) continue;
      ++bridged;
      bridged_time = state.time;
      continue;
    }
    if (!path.poses.empty() && bridged >= limits.min_lost_frames &&
        bridged_time - measured_time > limits.max_lost_seconds)
      path.gaps.push_back({static_cast<int>(path.poses.size()), limits.depth_sigma});
    path.poses.push_back(poses[i]);
    bridged = 0;
    measured_time = state.time;
  }
  return path;
}

}  // namespace turnscale
