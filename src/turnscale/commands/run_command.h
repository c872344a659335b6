// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/commands/command_hooks.h"
#include "turnscale/commands/drive_source.h"
#include "turnscale/commands/run_page.h"
#include "turnscale/run/run_drive.h"
#include "turnscale/run/settings.h"

namespace turnscale {

/// The car as arguments give it, by the names of the program's options.
struct CarArguments {
  std::optional<double> lever_arm;           ///< metres
  std::optional<double> lever_arm_sigma;     ///< metres
  std::optional<std::string> camera_height;  ///< metres, or "H,SIGMA"
  std::optional<std::filesystem::path> vehicle;
  std::optional<double> side_slip;        ///< s^2/m
  std::optional<double> side_slip_sigma;  ///< s^2/m
  std::string camera_rotation;            ///< degrees, a file, or "auto"; empty: as `vehicle` or the settings have it
  std::optional<std::string> method;      ///< "smoothed", "turns" or "paper"
};

/// The settings file, overridden by the arguments. Throws InputError that names the option.
Settings SettingsFrom(const CarArguments& car, const std::optional<std::filesystem::path>& file);

/// Arguments of `run`.
struct RunArguments {
  ImageArguments images;
  CarArguments car;
  std::string frame = "camera";  ///< or "vehicle"
  int threads = kImageThreads;
  std::filesystem::path out = "out";
  TruthFiles truth;
  bool no_report = false;
};

/// What the caller of a run is asked and told besides.
struct RunHooks : CommandHooks {
  /// Called when the drive is found, with the number of its frames (0 if unknown) and the time of its first one.
  std::function<void(int, double)> opened = [](int, double) {};
  /// Told what goes on: before the first frame, and after the last; empty for the frames themselves.
  std::function<void(const std::string&)> phase = [](const std::string&) {};
  /// Called before each frame is read; may wait.
  std::function<void()> before_frame = [] {};
  /// Called after each frame with its result.
  std::function<void(const SourceFrame&, const FrameResult&, const Odometry&)> watch = {};
};

/// Runs the odometry over a drive and writes the results to `out`. Throws InputError, OutputError and Interruption as
/// long as there are no results; later failures are in what it returns.
RunEnd ExecuteRun(const RunArguments& arguments, const RunHooks& hooks);

/// Why a run did not come to its end, or lacks results.
struct RunFailure {
  Failure first;                    ///< without saying what was kept
  std::vector<std::string> others;  ///< what failed besides, a line each
  bool kept = true;                 ///< there are results
};

/// Nothing where all went well.
std::optional<RunFailure> FailureOfRun(const RunEnd& end);

}  // namespace turnscale
