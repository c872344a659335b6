// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace turnscale {

/// The truth that a page of a run shows beside its path; empty where there is none.
struct TruthFiles {
  std::filesystem::path truth;
  std::filesystem::path floor_plan;
};

/// Throws InputError where one of them cannot be read, or there is a floor plan only: before a run, which may take
/// hours.
void CheckTruthFiles(const TruthFiles& files);

/// Makes report.html in the folder of a run, with the comparison if there is a truth; that of an earlier page of the
/// folder is kept if there is none. Returns what makes the comparison doubtful, a line each. Throws InputError,
/// OutputError.
std::vector<std::string> WriteRunPage(const std::filesystem::path& folder, const TruthFiles& files);

}  // namespace turnscale
