// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace turnscale {

struct SimulatorCommand;

/// Adds a sub-command that the executable turnscale-simulator carries out in place of this process: it is a package of
/// its own, so that the program needs neither Embree nor the laboratory. Where it is not installed, a call throws
/// InputError.
void AddInstalledCommand(CLI::App& app, const SimulatorCommand& command);

/// A sub-command that this build comes without: not in the help, and its call, whatever its arguments, says what
/// enables it.
void AddMissingCommand(CLI::App& app, const SimulatorCommand& command, const std::string& part,
                       const std::string& option);

}  // namespace turnscale
