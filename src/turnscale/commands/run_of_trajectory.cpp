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
  bool measured = false;
  bool bridged = false;
};

// Of the frames with a pose.
std::vector<FrameState> StatesIn(const fs::path& file) {
  CsvTable table(file, "table of frames");
  const auto time = table.Column("time");
  const auto state = table.Column("state");
  const auto x = table.Column("x");
  std::vector<FrameState> states;
  while (table.Next()) {
    if (table.Text(x).empty()) continue;
    const std::string& name = table.Text(state);
    const auto is = [&](TrackingState one) { return name == TrackingStateName(one); };
    states.push_back({table.Value<double>(time), is(TrackingState::kTracked) || is(TrackingState::kRepeated),
                      is(TrackingState::kBridged)});
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
  const fs::path file = trajectory.parent_path() / RunFiles::kTrajectoryTable;
  std::error_code none;
  if (!IsOfRun(trajectory) || !fs::exists(file, none)) return {poses, {}, 0};
  const std::vector<FrameState> states = StatesIn(file);
  const bool one_by_one = states.size() == poses.size();
  const TrackingOptions limits;
  MeasuredPath path;
  int lost = 0;  // images without a pose since the last measured one
  size_t row = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    // live.tum lacks the frames whose poses were found later.
    constexpr double kRounding = 2e-6;
    while (!one_by_one && row < states.size() && states[row].time < poses[i].time - kRounding) ++row;
    if (one_by_one) row = i;
    if (row < states.size() && !states[row].measured) {
      ++path.left_out;
      lost += states[row].bridged ? 1 : 0;
      continue;
    }
    const bool restarted = lost >= limits.min_lost_frames && !path.poses.empty();
    if (restarted) path.gaps.push_back({static_cast<int>(path.poses.size()), limits.depth_sigma});
    path.poses.push_back(poses[i]);
    lost = 0;
  }
  return path;
}

}  // namespace turnscale
