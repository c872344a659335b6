// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/commands/command_hooks.h"
#include "turnscale/rescale/rescale.h"

namespace turnscale {

/// Arguments of `rescale`, by the names of the program's options.
struct RescaleArguments {
  std::filesystem::path input;
  std::optional<double> lever_arm;  ///< metres
  std::optional<double> lever_arm_sigma;
  std::optional<double> side_slip;               ///< s^2/m
  std::optional<double> side_slip_sigma;         ///< s^2/m
  std::optional<std::filesystem::path> heights;  ///< CSV file: time, height, sigma
  std::optional<std::string> camera_height;      ///< metres, or "H,SIGMA"
  std::string camera_rotation = "auto";          ///< degrees, a file, "identity" or "auto"
  std::optional<double> fps;
  std::optional<std::filesystem::path> timestamps;
  std::string drift = "auto";                ///< or "none"
  std::filesystem::path out = "metric.tum";  ///< empty: not written
  std::optional<std::filesystem::path> report;
  bool quiet = false;
};

/// What a rescale has found, and what there is to say of it.
struct RescaleOutcome {
  RescaleResult result;
  bool timed = true;                  ///< the input has times, or was given them
  std::vector<std::string> warnings;  ///< all that the hooks were told, one line each
};

/// Converts an up-to-scale trajectory to metres and writes the files. Throws InputError, also where the scale is not
/// observable, and OutputError.
RescaleOutcome ExecuteRescale(const RescaleArguments& arguments, const CommandHooks& hooks);

}  // namespace turnscale
