// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace turnscale {

/// A sub-command of the executable turnscale-simulator, which turnscale offers too.
struct SimulatorCommand {
  const char* name;
  const char* what;
};

inline constexpr SimulatorCommand kSimulateCommand = {"simulate", "Render a simulated drive with ground truth."};
inline constexpr SimulatorCommand kLabCommand = {
    "lab", "Reproduce the analysis and Monte Carlo runs of the paper by Kim et al. (sections V-A, V-B)."};

/// The main function of both executables: runs the sub-command that `argv` names, of those that `add_commands` adds.
/// Prints any error as one line and returns the exit code.
int RunProgram(int argc, char** argv, void (*add_commands)(CLI::App&));

/// What --version prints, without the name: version and commit, such as `0.2.0 (v0.2.0-3-g7c2e71e)`. Without the commit
/// where the source does not tell it.
std::string VersionWithCommit();

}  // namespace turnscale
