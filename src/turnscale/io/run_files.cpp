// SPDX-License-Identifier: MIT
#include "turnscale/io/run_files.h"

#include <algorithm>
#include <array>
#include <system_error>

namespace turnscale {
namespace {

bool HasFile(const std::filesystem::path& folder, const char* name) {
  std::error_code none;
  return std::filesystem::is_regular_file(folder / name, none);
}

}  // namespace

bool HasPosesOfRun(const std::filesystem::path& folder) {
  return std::ranges::any_of(std::array{RunFiles::kTrajectoryTable, RunFiles::kLiveTum, RunFiles::kLiveTumPart},
                             [&](const char* name) { return HasFile(folder, name); });
}

bool HasResultsOfRun(const std::filesystem::path& folder) {
  return HasFile(folder, RunFiles::kTrajectoryTable) && HasFile(folder, RunFiles::kSummary);
}

}  // namespace turnscale
