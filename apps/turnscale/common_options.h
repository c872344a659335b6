// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/commands/drive_source.h"
#include "turnscale/commands/option_rules.h"
#include "turnscale/commands/run_page.h"

namespace CLI {
class App;
}

namespace turnscale {

/// What a file of frame times may contain; the unit is detected.
inline constexpr const char* kTimesPerLine = "one per line: seconds, milliseconds since 1970, or micro- or nanoseconds";

/// Adds the options that name, assume or refine the camera.
void AddCameraOptions(CLI::App& command, ImageArguments& arguments);

/// Adds the option of a bag's topic, and those of the part of a drive and of its images to process.
void AddPartOptions(CLI::App& command, ImageArguments& arguments);

/// --side-slip and --side-slip-sigma.
void AddSideSlipOptions(CLI::App& command, std::optional<double>& side_slip, std::optional<double>& sigma);

/// --truth and --floor-plan.
void AddTruthOptions(CLI::App& command, TruthFiles& files);

/// Declares which options of a command go together, once it has all of them.
void DeclareRules(const OptionRules& rules, CLI::App& command);

}  // namespace turnscale
