// SPDX-License-Identifier: MIT
#include "installed_simulator.h"

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "process.h"
#include "program.h"
#include "turnscale/base/error.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr auto kSimulator = "turnscale-simulator";

[[noreturn]] void ExecSimulator(const std::string& name, const std::vector<std::string>& arguments) {
  const fs::path simulator = FindBesideProgram(fs::path(TURNSCALE_LIBEXEC_FROM_PROGRAM) / kSimulator, kSimulator);
  if (simulator.empty()) {
    throw InputError(name + ": the simulator is not installed; install the package " + kSimulator);
  }
  std::vector<std::string> words = {simulator.string(), name};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const std::string error = ReplaceProcess(words);
  throw InputError(simulator.string() + ": cannot be run: " + error + "; install the package " + kSimulator + " again");
}

}  // namespace

void AddInstalledCommand(CLI::App& app, const SimulatorCommand& command) {
  CLI::App* added = AddUnparsedCommand(app, command.name, command.what);
  added->parse_complete_callback(
      [added, name = std::string(command.name)] { ExecSimulator(name, added->remaining()); });
}

void AddMissingCommand(CLI::App& app, const SimulatorCommand& command, const std::string& part,
                       const std::string& option) {
  AddUnparsedCommand(app, command.name, command.what)
      ->group("")
      ->parse_complete_callback([name = std::string(command.name), part, option] {
        throw InputError(name + ": this build has no " + part + "; configure it with -D" + option + "=ON");
      });
}

}  // namespace turnscale
