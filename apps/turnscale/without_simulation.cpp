// SPDX-License-Identifier: MIT
#include "commands.h"

namespace turnscale {

void AddSimulateCommand(CLI::App& app) {
  AddMissingCommand(app, "simulate", "simulator", "TURNSCALE_BUILD_SIMULATION");
}

}  // namespace turnscale
