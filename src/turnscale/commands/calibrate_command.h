// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/commands/command_hooks.h"
#include "turnscale/commands/drive_source.h"
#include "turnscale/commands/option_rules.h"
#include "turnscale/run/calibration_report.h"

namespace turnscale {

/// Arguments of `calibrate`, by the names of the program's options.
struct CalibrateArguments {
  ImageArguments images;                            ///< of the drive, unless there is a trajectory
  std::optional<std::filesystem::path> trajectory;  ///< its file, or the folder of a run
  std::string axes = "auto";                        ///< of the trajectory: "auto", "camera", "flu" or "frd"
  std::optional<std::filesystem::path> speed;
  std::optional<double> distance;  ///< metres
  bool metric = false;
  std::optional<double> lever_arm;  ///< metres
  std::optional<double> side_slip;  ///< s^2/m
  bool fit_side_slip = false;
  std::optional<std::filesystem::path> history;    ///< CSV file to write; a plot comes beside it
  bool keep_history = false;                       ///< in the outcome
  std::filesystem::path out = "calibration.yaml";  ///< empty: not written

  bool in_metres() const { return speed || distance || metric; }
};

/// Which of the program's options go together.
OptionRules CalibrateRules();

struct CalibrateOutcome {
  std::optional<CalibrationReport> report;  ///< empty where the drive was stopped before it sufficed
  std::vector<CalibrationMoment> history;   ///< if it is kept
  std::string note;                         ///< one line about the motion; may be empty
  std::optional<Failure> stopped;           ///< why the drive was not processed to its end
};

/// Estimates the camera-to-vehicle rotation, and where metres are given the lever arm, and writes the files. Throws
/// InputError, OutputError and Interruption unless the drive was stopped.
CalibrateOutcome ExecuteCalibrate(const CalibrateArguments& given, const CommandHooks& hooks);

}  // namespace turnscale
