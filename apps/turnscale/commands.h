// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

namespace turnscale {

/// Each adds its sub-command. The sub-command's callback throws InputError or OutputError, or CLI::RuntimeError with an
/// exit code of its own.
void AddRunCommand(CLI::App& app);
void AddBatchCommand(CLI::App& app);
void AddCalibrateCommand(CLI::App& app);
void AddEvaluateCommand(CLI::App& app);
void AddExportCommand(CLI::App& app);
void AddLabCommand(CLI::App& app);
void AddRescaleCommand(CLI::App& app);
void AddSimulateCommand(CLI::App& app);
void AddViewCommand(CLI::App& app);

}  // namespace turnscale
