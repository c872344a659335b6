// SPDX-License-Identifier: MIT
#include "turnscale/rescale/rescale.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "argument_checks.h"
#include "commands.h"
#include "drive_source.h"
#include "rescale_page.h"
#include "rescale_report.h"
#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/drive_input.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/run_writer.h"
#include "turnscale/io/settings.h"
#include "turnscale/io/terminal.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct RescaleArguments {
  fs::path input;
  double lever_arm = 0;
  std::optional<double> lever_arm_sigma;
  std::optional<double> side_slip;
  std::optional<double> side_slip_sigma;
  std::string camera_rotation = "auto";
  std::optional<double> fps;
  std::optional<fs::path> timestamps;
  std::string drift = "auto";
  fs::path out = "metric.tum";
  std::optional<fs::path> report;
  bool quiet = false;
};

RescaleOptions OptionsFrom(const RescaleArguments& arguments, bool timed) {
  RescaleOptions options;
  options.car.lever_arm = CheckedLeverArm(arguments.lever_arm);
  if (arguments.side_slip) {
    options.car.side_slip = CheckedSideSlip(*arguments.side_slip);
    options.car.side_slip_sigma = kGivenSideSlipSigma * options.car.side_slip;
  }
  if (arguments.lever_arm_sigma) options.car.lever_arm_sigma = CheckedLeverArmSigma(*arguments.lever_arm_sigma);
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

void WriteReport(const fs::path& folder, const RescaleResult& result, const std::string& input, double lever_arm,
                 bool timed) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot be made: " + error.message());
  // The summary comes last: where it is, the others are of the same drive.
  for (const char* name : {"summary.json", "scale.csv", "turns.csv", "rescale.svg", kReportFile})
    RemoveOldFile(folder / name);
  ReplaceFile(folder / "scale.csv", PoseScaleTable(result));
  ReplaceFile(folder / "turns.csv", TurnScaleTable(result));
  ReplaceFile(folder / "rescale.svg", RescaleSvg(result, fs::path(input).filename().string(), timed));
  ReplaceFile(folder / kReportFile, RescalePage(result, input, lever_arm, timed));
  ReplaceFile(folder / "summary.json", RescaleJson(result, input));
}

void RunRescale(const RescaleArguments& arguments) {
  RefuseToOverwrite("--out", arguments.out, {arguments.input, arguments.timestamps.value_or("")});
  const TimedTrajectory trajectory = ReadTimedTrajectory(arguments.input, arguments.timestamps, arguments.fps);
  const std::string input = arguments.input.string();
  if (!trajectory.timed && !arguments.quiet) {
    PrintMessage("warning: " + input +
                 ": no timestamps, so tyre slip is neglected: the scale may be off by up to 40 %; give --fps or "
                 "--timestamps");
  }
  if (trajectory.poses.size() < 2) throw InputError(input + ": has fewer than two poses");
  const RescaleOptions options = OptionsFrom(arguments, trajectory.timed);
  const RescaleResult result = RescaleTrajectory(options, trajectory.poses);
  if (!result.observable) {
    throw InputError(fmt::format("{}: scale not observable: {}", input, result.reason));
  }
  std::string tum;
  for (const StampedPose& pose : result.metric) tum += TumLine(pose);
  ReplaceFile(arguments.out, tum);
  if (arguments.report) WriteReport(*arguments.report, result, input, options.car.lever_arm, trajectory.timed);
  if (const std::string warning = RescaleWarning(result); !warning.empty())
    PrintMessage("warning: " + input + ": " + warning);
  if (!arguments.quiet) PrintText(RescaleText(result));
}

}  // namespace

void AddRescaleCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("rescale", "Convert an up-to-scale trajectory of any monocular SLAM to metres.");
  const auto arguments = std::make_shared<RescaleArguments>();
  const CarPrior car;
  command
      ->add_option("FILE", arguments->input,
                   "Up-to-scale trajectory: TUM, KITTI (12 numbers per line, or 13 with the frame number) or EuRoC CSV")
      ->required();
  command->add_option("--lever-arm", arguments->lever_arm, "Distance from the rear axle forward to the camera, metres")
      ->required();
  command->add_option("--lever-arm-sigma", arguments->lever_arm_sigma,
                      fmt::format("Standard deviation of --lever-arm, metres [{}]", kTapeSigma));
  command->add_option(
      "--side-slip", arguments->side_slip,
      fmt::format("Slip-angle coefficient c in L_eff = L - c v^2: slip angle of the rear axle per lateral "
                  "acceleration, rad per m/s^2 (= s^2/m); 0: no slip. Refined from the drive unless its "
                  "sigma is 0 [{}]",
                  car.side_slip));
  command->add_option(
      "--side-slip-sigma", arguments->side_slip_sigma,
      fmt::format(
          "Standard deviation of c, s^2/m; 0: c is not refined [{}, or {:.0f} % of --side-slip if that is given]",
          car.side_slip_sigma, 100 * kGivenSideSlipSigma));
  command->add_option("--camera-rotation", arguments->camera_rotation,
                      "Camera-to-vehicle rotation: auto (estimated from the trajectory); identity; yaw,pitch,roll in "
                      "degrees; or a YAML file, as for run [auto]");
  CLI::Option* fps = command->add_option("--fps", arguments->fps, "Frames per second of a KITTI trajectory");
  command
      ->add_option("--timestamps", arguments->timestamps,
                   "Times of a KITTI trajectory's frames in seconds, one per line [times.txt beside it]")
      ->excludes(fps);
  command
      ->add_option("--drift", arguments->drift,
                   "auto: the log-scale is a random walk along the drive; none: constant scale, for loop-closed "
                   "trajectories [auto]")
      ->check(CLI::IsMember({"auto", "none"}));
  command->add_option("--out", arguments->out, "File for the trajectory in metres, TUM [metric.tum]");
  command->add_option("--report", arguments->report,
                      "Folder for report.html, scale.csv, turns.csv, summary.json and rescale.svg");
  command->add_flag("--quiet", arguments->quiet, "Print only errors, and a warning if single-turn scales are used");
  command->footer(
      "Example:\n  turnscale rescale orbslam.tum --lever-arm 1.05 --out metric.tum --report out/\n\n"
      "Without a sufficiently slow turn the scale is not observable: nothing is written, and the exit code is 2.");
  command->callback([arguments] { RunRescale(*arguments); });
}

}  // namespace turnscale
