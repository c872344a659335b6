// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>

#include "commands.h"
#include "program.h"

namespace turnscale {
namespace {

void AddCommands(CLI::App& app) {
  if constexpr (TURNSCALE_WITH_SIMULATION) AddSimulateCommand(app);
  if constexpr (TURNSCALE_WITH_LABORATORY) AddLabCommand(app);
}

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) { return turnscale::RunProgram(argc, argv, turnscale::AddCommands); }
