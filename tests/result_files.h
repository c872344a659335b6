// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace turnscale {

/// Names of all that `turnscale run` writes but settings.yaml and summary.json.
const std::vector<std::string>& NamesOfResults();

/// Fails the test where a file in the folder of a run is not whole, but for those whose name says so (*.part).
void ExpectWholeFiles(const std::filesystem::path& folder);

}  // namespace turnscale
