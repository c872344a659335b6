// SPDX-License-Identifier: MIT
#include "turnscale/commands/run_of_trajectory.h"

#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>

#include "turnscale/base/csv_table.h"
#include "turnscale/io/run_files.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/missing_path.h"

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
  int frame = 0;
  bool lost = false;  // as FindMissingParts has it: a repeated image within a loss is part of it
};

// Of the frames with a pose; empty if the file is not of a run.
std::vector<FrameState> StatesIn(const fs::path& file) {
  std::vector<FrameState> states;
  std::error_code none;
  if (!fs::exists(file, none)) return states;
  CsvTable table(file, "table of frames");
  for (const char* column : {"frame", "state", "x"})
    if (!table.HasColumn(column)) return states;
  const auto frame = table.Column("frame");
  const auto state = table.Column("state");
  const auto x = table.Column("x");
  bool lost = false;
  while (table.Next()) {
    if (table.Text(x).empty()) continue;
    const std::string& name = table.Text(state);
    const auto is = [&](TrackingState one) { return name == TrackingStateName(one); };
    lost = is(TrackingState::kBridged) || is(TrackingState::kUnreadable) || (lost && is(TrackingState::kRepeated));
    states.push_back({table.Value<int>(frame), lost});
  }
  return states;
}

// Where the run's map began anew, in the order of frames; empty if its summary does not say, as those of earlier
// versions.
std::optional<std::vector<MapRestart>> RestartsOf(const fs::path& trajectory) {
  const nlohmann::json missing = OfRun(trajectory, "missing");
  if (!missing.is_object() || !missing.contains("restarts")) return std::nullopt;
  std::vector<MapRestart> restarts;
  for (const nlohmann::json& restart : missing["restarts"]) {
    const auto number = [&](const char* name) {
      return restart.is_object() && restart.contains(name) && restart[name].is_number();
    };
    if (number("frame") && number("unit_sigma"))
      restarts.push_back({restart["frame"].get<int>(), 0, restart["unit_sigma"].get<double>()});
  }
  return restarts;
}

}  // namespace

nlohmann::json ScaleOfRun(const fs::path& trajectory) { return OfRun(trajectory, "scale"); }

std::string ScaleStateOfRun(const fs::path& trajectory) {
  const nlohmann::json scale = ScaleOfRun(trajectory);
  return scale.contains("state") && scale["state"].is_string() ? scale["state"].get<std::string>() : "";
}

std::optional<double> FirstTimeOfRun(const fs::path& trajectory) {
  if (trajectory.filename() == RunFiles::kTrajectoryKitti) return std::nullopt;
  const nlohmann::json first = OfRun(trajectory, "first_frame_s");
  return first.is_number() ? std::optional(first.get<double>()) : std::nullopt;
}

std::optional<double> PathLengthOfRun(const fs::path& trajectory) {
  if (trajectory.filename() == RunFiles::kLiveTum) return std::nullopt;
  for (const char* name : {"distance_m", "distance_units"})
    if (const nlohmann::json length = OfRun(trajectory, name); length.is_number()) return length.get<double>();
  return std::nullopt;
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
  MeasuredPath path;
  const std::optional<std::vector<MapRestart>> restarts = RestartsOf(trajectory);
  size_t next = 0;  // of the restarts
  bool lost = false;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (states[i].lost) {
      ++path.left_out;
      lost = true;
      continue;
    }
    // Of all maps that began since the last measured pose; of any that may have, where that is not known.
    double sigma = !restarts && lost ? TrackingOptions().depth_sigma : 0;
    for (; restarts && next < restarts->size() && (*restarts)[next].frame <= states[i].frame; ++next)
      sigma = std::hypot(sigma, (*restarts)[next].unit_sigma);
    if (sigma > 0 && !path.poses.empty()) path.gaps.push_back({static_cast<int>(path.poses.size()), sigma});
    path.poses.push_back(poses[i]);
    lost = false;
  }
  return path;
}

}  // namespace turnscale
