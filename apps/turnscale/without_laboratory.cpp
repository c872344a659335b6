// SPDX-License-Identifier: MIT
#include "commands.h"

namespace turnscale {

void AddLabCommand(CLI::App& app) { AddMissingCommand(app, "lab", "laboratory", "TURNSCALE_BUILD_LABORATORY"); }

}  // namespace turnscale
