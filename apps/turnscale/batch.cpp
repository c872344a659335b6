// SPDX-License-Identifier: MIT
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "commands.h"
#include "process.h"
#include "turnscale/base/error.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// The Python package, beside the installed program or in the build folder.
fs::path BatchFolder(const fs::path& program) {
  const fs::path folder = program.parent_path();
  for (const fs::path& candidate :
       {folder / TURNSCALE_DATA_FROM_PROGRAM / "fleet/turnscale_batch", folder / "fleet/turnscale_batch"}) {
    std::error_code none;
    if (fs::is_regular_file(candidate / "__main__.py", none)) return fs::canonical(candidate);
  }
  throw InputError("batch: its Python files are missing; install turnscale again");
}

[[noreturn]] void ExecBatch(const std::vector<std::string>& arguments) {
  const fs::path program = ProgramFile();
  // The runs of the drives are this program's.
  setenv("TURNSCALE_PROGRAM", program.c_str(), 1);
  std::vector<std::string> words = {"python3", BatchFolder(program).string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  throw InputError("batch: needs python3: " + ReplaceProcess(words) +
                   "; install the Debian packages python3, python3-dask, python3-distributed and python3-numpy");
}

}  // namespace

void AddBatchCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("batch", "Run many drives, on this machine or on a Dask cluster; see turnscale batch --help.")
          ->prefix_command();
  command->set_help_flag();
  command->parse_complete_callback([command] { ExecBatch(command->remaining()); });
}

}  // namespace turnscale
