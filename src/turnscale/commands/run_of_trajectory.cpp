// SPDX-License-Identifier: MIT
#include "turnscale/commands/run_of_trajectory.h"

#include <fstream>

#include "turnscale/io/run_files.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// A member of the summary; null if there is none.
nlohmann::json OfRun(const fs::path& trajectory, const char* member) {
  const fs::path name = trajectory.filename();
  if (name != RunFiles::kTrajectoryTum && name != RunFiles::kTrajectoryKitti && name != RunFiles::kLiveTum) return {};
  std::ifstream file(trajectory.parent_path() / RunFiles::kSummary);
  const nlohmann::json summary = nlohmann::json::parse(file, nullptr, false);
  return summary.is_object() && summary.contains(member) ? summary[member] : nlohmann::json();
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

}  // namespace turnscale
