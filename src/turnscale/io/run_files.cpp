// SPDX-License-Identifier: MIT
#include "turnscale/io/run_files.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>

#include <nlohmann/json.hpp>

#include "turnscale/base/file_text.h"
#include "turnscale/io/output_file.h"

namespace turnscale {
namespace {

bool HasFile(const std::filesystem::path& folder, const char* name) {
  std::error_code none;
  return std::filesystem::is_regular_file(folder / name, none);
}

bool HasText(const std::filesystem::path& folder, const char* name) {
  std::error_code error;
  return HasFile(folder, name) && std::filesystem::file_size(folder / name, error) > 0 && !error;
}

// A table of that name may be of another program.
bool HasTableOfRun(const std::filesystem::path& folder) {
  if (!HasFile(folder, RunFiles::kTrajectoryTable)) return false;
  std::ifstream stream(folder / RunFiles::kTrajectoryTable);
  std::string header;
  return std::getline(stream, header) && header.starts_with("frame,time,state,");
}

}  // namespace

bool HasPosesOfRun(const std::filesystem::path& folder) {
  return HasFile(folder, RunFiles::kTrajectoryTable) || HasText(folder, RunFiles::kLiveTum) ||
         HasText(folder, RunFiles::kLiveTumPart);
}

bool SummaryHas(const std::filesystem::path& folder, std::initializer_list<const char*> keys) {
  if (!HasFile(folder, RunFiles::kSummary)) return false;
  const auto json = nlohmann::json::parse(FileText(folder / RunFiles::kSummary).value_or(""), nullptr, false);
  return json.is_object() && std::ranges::all_of(keys, [&](const char* key) { return json.contains(key); });
}

bool IsFolderOfRun(const std::filesystem::path& folder) {
  // A run without a pose leaves a summary, but no trajectory.
  return HasFile(folder, RunFiles::kLiveTumPart) || HasFile(folder, RunFiles::kLiveTum) || HasTableOfRun(folder) ||
         SummaryHas(folder, {"camera_yaw_pitch_roll_deg", "frames"});
}

std::filesystem::path ForeignFile(const std::filesystem::path& folder) {
  if (IsFolderOfRun(folder)) return {};
  for (const char* name : RunFiles::kAll)
    for (const std::filesystem::path& file : {folder / name, PartOf(folder / name)})
      if (HasFile(folder, file.filename().c_str())) return file;
  return {};
}

bool HasResultsOfRun(const std::filesystem::path& folder) {
  return HasFile(folder, RunFiles::kTrajectoryTable) && HasFile(folder, RunFiles::kSummary);
}

}  // namespace turnscale
