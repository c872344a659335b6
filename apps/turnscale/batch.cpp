// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "commands.h"
#include "process.h"
#include "turnscale/base/error.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void ExecBatch(const std::vector<std::string>& arguments) {
  const fs::path entry = fs::path("fleet") / "turnscale_batch" / "__main__.py";
  const fs::path script = FindBesideProgram(TURNSCALE_DATA_FROM_PROGRAM / entry, entry);
  if (script.empty()) throw InputError("batch: its Python files are missing; install turnscale again");
  // The runs of the drives are this program's.
  setenv("TURNSCALE_PROGRAM", ProgramFile().c_str(), 1);
  std::vector<std::string> words = {"python3", fs::canonical(script).parent_path().string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  throw InputError("batch: needs python3: " + ReplaceProcess(words) +
                   "; install the Debian packages python3, python3-dask, python3-distributed and python3-numpy");
}

}  // namespace

void AddBatchCommand(CLI::App& app) {
  CLI::App* command = AddUnparsedCommand(
      app, "batch", "Run many drives, on this machine or on a Dask cluster; see turnscale batch --help.");
  command->parse_complete_callback([command] { ExecBatch(command->remaining()); });
}

}  // namespace turnscale
