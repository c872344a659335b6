// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>

#include "commands.h"
#include "installed_simulator.h"
#include "program.h"

namespace turnscale {
namespace {

void AddCommands(CLI::App& app) {
  AddRunCommand(app);
  AddBatchCommand(app);
  AddCalibrateCommand(app);
  AddEvaluateCommand(app);
  AddExportCommand(app);
  AddRescaleCommand(app);
  if constexpr (TURNSCALE_WITH_SIMULATION) {
    AddInstalledCommand(app, kSimulateCommand);
  } else {
    AddMissingCommand(app, kSimulateCommand, "simulator", "TURNSCALE_BUILD_SIMULATION");
  }
  if constexpr (TURNSCALE_WITH_LABORATORY) {
    AddInstalledCommand(app, kLabCommand);
  } else {
    AddMissingCommand(app, kLabCommand, "laboratory", "TURNSCALE_BUILD_LABORATORY");
  }
  AddViewCommand(app);
}

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) { return turnscale::RunProgram(argc, argv, turnscale::AddCommands); }
