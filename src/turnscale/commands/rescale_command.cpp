// SPDX-License-Identifier: MIT
#include "turnscale/commands/rescale_command.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/commands/argument_checks.h"
#include "turnscale/commands/drive_source.h"
#include "turnscale/commands/rescale_page.h"
#include "turnscale/commands/rescale_report.h"
#include "turnscale/commands/rescaled_folder.h"
#include "turnscale/commands/run_of_trajectory.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/height_file.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/time_unit.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/run_writer.h"
#include "turnscale/run/settings.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

RescaleOptions OptionsFrom(const RescaleArguments& arguments, bool timed) {
  RescaleOptions options;
  if (arguments.lever_arm) {
    options.car.lever_arm = CheckedLeverArm(*arguments.lever_arm);
    options.car.lever_arm_sigma = TapeSigma(options.car.lever_arm);
  }
  if (arguments.camera_height) {
    const CameraHeight height = ParseCameraHeight(*arguments.camera_height);
    options.car.camera_height = height.metres;
    options.car.camera_height_sigma = height.sigma.value_or(kGivenHeightSigma * height.metres);
  }
  if (arguments.side_slip) {
    options.car.side_slip = CheckedSideSlip(*arguments.side_slip);
    options.car.side_slip_sigma = SigmaOfGivenSideSlip(options.car.side_slip);
  }
  if (arguments.lever_arm_sigma)
    options.car.lever_arm_sigma = CheckedLeverArmSigma(*arguments.lever_arm_sigma, arguments.lever_arm);
  if (arguments.side_slip_sigma) options.car.side_slip_sigma = CheckedSideSlipSigma(*arguments.side_slip_sigma);
  if (arguments.camera_rotation == "identity") {
    options.vehicle_from_camera = Eigen::Quaterniond::Identity();
  } else if (arguments.camera_rotation != "auto") {
    options.vehicle_from_camera = ReadCameraRotation(arguments.camera_rotation);
  }
  options.timed = timed;
  options.drifting = arguments.drift == "auto";
  return options;
}

// The files of --report, in the order in which old ones are taken away.
constexpr std::array kReportFiles = {kRescaledTum,  RunFiles::kScale, RunFiles::kTurns,
                                     "rescale.svg", kReportFile,      RunFiles::kSummary};

// Throws InputError where --report would replace files that are not of an earlier rescale.
void CheckReportFolder(const fs::path& folder) {
  std::error_code none;
  if (IsFolderOfRun(folder) || fs::exists(folder / RunFiles::kTrajectoryTable, none))
    throw InputError("--report: " + folder.string() +
                     ": has the results of a run, some of which would be replaced; choose another --report");
  if (IsRescaleFolder(folder)) return;
  for (const char* name : kReportFiles)
    if (fs::is_regular_file(folder / name, none))
      throw InputError("--report: " + (folder / name).string() +
                       ": would be replaced, but is not of an earlier rescale; choose another --report");
}

// Also the times that ReadTimedTrajectory may find by itself; a rotation in degrees names no file.
std::vector<fs::path> FilesRead(const RescaleArguments& arguments) {
  return {arguments.input, arguments.timestamps.value_or(FindPoseTimes(arguments.input)),
          arguments.heights.value_or(""), arguments.camera_rotation};
}

void CheckArguments(const RescaleArguments& arguments) {
  RefuseBoth({"--timestamps", arguments.timestamps.has_value()}, {"--fps", arguments.fps.has_value()});
  CheckChoice("--drift", arguments.drift, {"auto", "none"});
  RequireFor({"--camera-height", arguments.camera_height.has_value()}, arguments.heights.has_value(), "--heights");
  RequireFor({"--lever-arm-sigma", arguments.lever_arm_sigma.has_value()}, arguments.lever_arm.has_value(),
             "--lever-arm");
  if (!arguments.lever_arm && !arguments.camera_height)
    throw InputError("--lever-arm: is missing; give it, or --camera-height with --heights");
  std::vector<NamedOutput> outputs{{"--out", arguments.out}};
  if (arguments.report)
    for (const char* name : kReportFiles) outputs.push_back({"--report", *arguments.report / name});
  CheckOutputs(outputs, FilesRead(arguments));
  RefuseResultsOfRun({{"--out", arguments.out}});
  if (arguments.report) CheckReportFolder(*arguments.report);
}

std::vector<PathHeight> HeightsAlong(const Trajectory& poses, const std::optional<fs::path>& path,
                                     const CommandHooks& hooks) {
  if (!path) return {};
  constexpr double kLeastShare = 0.1;
  std::vector<PathHeight> heights = ReadHeightFile(*path);
  const double first = poses.front().time;
  const double last = poses.back().time;
  const auto within = std::ranges::count_if(
      heights, [&](const PathHeight& height) { return height.time >= first && height.time <= last; });
  if (within == 0)
    throw InputError(
        fmt::format("{}: no height is at a time of the trajectory, {} to {}", path->string(), first, last));
  if (static_cast<double>(within) < kLeastShare * static_cast<double>(heights.size()))
    Warn(hooks, fmt::format("{}: only {} of {} heights are at times of the trajectory, {} to {} s: check that their "
                            "times are seconds of the same clock",
                            path->string(), within, heights.size(), first, last));
  return heights;
}

std::string TumText(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& pose : trajectory) text += TumLine(pose);
  return text;
}

void WriteReport(const fs::path& folder, const RescaleOutcome& outcome, const std::string& input, const CarPrior& car,
                 std::optional<double> first_time) {
  const RescaleResult& result = outcome.result;
  const bool timed = outcome.timed;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) RefusePlace(folder.string() + ": cannot be made", error, "choose another --report");
  for (const char* name : kReportFiles) RemoveOldFile(folder / name);
  // Its part marks the folder; it gets its name last: where it is, the others are of the same drive.
  OutputFile summary(folder / RunFiles::kSummary);
  ReplaceFile(folder / kRescaledTum, TumText(result.metric));
  ReplaceFile(folder / RunFiles::kScale, PoseScaleTable(result));
  ReplaceFile(folder / RunFiles::kTurns, TurnScaleTable(result));
  ReplaceFile(folder / "rescale.svg", RescaleSvg(result, fs::path(input).filename().string(), timed));
  ReplaceFile(folder / kReportFile, RescalePage(result, input, car, timed, first_time));
  summary.Write(RescaleJson(result, input, timed, outcome.warnings));
  summary.Finish();
}

std::vector<double> TimesOf(const Trajectory& trajectory) {
  std::vector<double> times;
  for (const StampedPose& pose : trajectory) times.push_back(pose.time);
  return times;
}

// The same hooks, with a list of all warnings.
CommandHooks Listing(const CommandHooks& hooks, std::vector<std::string>& warnings) {
  CommandHooks listing = hooks;
  listing.warn = [warn = hooks.warn, &warnings](const std::string& warning) {
    warnings.push_back(warning);
    if (warn) warn(warning);
  };
  return listing;
}

}  // namespace

RescaleOutcome ExecuteRescale(const RescaleArguments& given, const CommandHooks& given_hooks) {
  RescaleOutcome outcome;
  const CommandHooks hooks = Listing(given_hooks, outcome.warnings);
  RescaleArguments arguments = given;
  arguments.input = TrajectoryOf(given.input);
  CheckArguments(arguments);
  const TimedTrajectory trajectory = ReadTimedTrajectory(arguments.input, arguments.timestamps, arguments.fps);
  outcome.timed = trajectory.timed;
  const std::string input = arguments.input.string();
  if (IsOfRearAxle(arguments.input))
    throw InputError(input +
                     ": the poses are those of the rear axle, which does not swing out in turns; run again without "
                     "--frame vehicle");
  if (!trajectory.timed && arguments.heights) {
    throw InputError(input + ": no timestamps, by which --heights finds its poses; give --fps or --timestamps");
  }
  if (trajectory.timed)
    RefuseSparseTimes(input, TimesOf(trajectory.poses), "Give seconds, or --fps with numbers of frames");
  const RescaleOptions options = OptionsFrom(arguments, trajectory.timed);
  if (!trajectory.timed && arguments.lever_arm && !options.car.is_rigid()) {
    Warn(hooks, fmt::format("{}: no timestamps: side slip is unknown, and taken as {:.0f} +-{:.0f} % of the lever arm; "
                            "give --fps or --timestamps",
                            input, 100 * options.untimed_slip, 100 * options.untimed_slip_sigma));
  }
  const MeasuredPath path = MeasuredPartOf(arguments.input, trajectory.poses);
  if (path.poses.size() < 2)
    throw InputError(input +
                     (path.left_out > 0 ? ": has fewer than two measured poses" : ": has fewer than two poses"));
  if (path.left_out > 0)
    Warn(hooks, fmt::format("{}: {} pose{} where the run had lost tracking {} left out", input, path.left_out,
                            path.left_out == 1 ? "" : "s", path.left_out == 1 ? "is" : "are"));
  outcome.result =
      RescaleTrajectory(options, path.poses, path.gaps, HeightsAlong(path.poses, arguments.heights, hooks));
  const RescaleResult& result = outcome.result;
  if (!result.observable) {
    throw InputError(fmt::format(
        "{}: scale not observable: {}{}", input, result.reason,
        trajectory.whole_numbers ? "; the times are whole numbers: if they are numbers of frames, give --fps" : ""));
  }
  for (const std::string& warning : RescaleWarnings(result, options.car))
    Warn(hooks, fmt::format("{}: {}", input, warning));
  if (!arguments.out.empty()) ReplaceFile(arguments.out, TumText(result.metric));
  // --fps replaces the times in the file.
  const std::optional<double> first_time = arguments.fps ? std::nullopt : FirstTimeOfRun(arguments.input);
  if (arguments.report) WriteReport(*arguments.report, outcome, input, options.car, first_time);
  return outcome;
}

}  // namespace turnscale
