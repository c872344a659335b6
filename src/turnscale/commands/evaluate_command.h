// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "turnscale/commands/command_hooks.h"
#include "turnscale/commands/comparison.h"

namespace turnscale {

/// Arguments of `evaluate`, by the names of the program's options; empty paths are not given.
struct EvaluateArguments : ComparisonFiles {
  std::string json;  ///< file to write; "-": none
  std::filesystem::path picture;
  std::filesystem::path report;
  std::filesystem::path floor_plan;
};

/// Compares a trajectory with the true one and writes the files. Throws InputError and OutputError.
Comparison ExecuteEvaluate(const EvaluateArguments& arguments, const CommandHooks& hooks);

}  // namespace turnscale
