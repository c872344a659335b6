// SPDX-License-Identifier: MIT
#include "turnscale/rescale/rescale.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "car_arguments.h"
#include "commands.h"
#include "output_arguments.h"
#include "rescale_picture.h"
#include "rescale_report.h"
#include "timed_trajectory.h"
#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/frame_times.h"
#include "turnscale/io/message.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/settings.h"
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

void WriteReport(const fs::path& folder, const RescaleResult& result, const std::string& input, bool timed) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string() + ": cannot be made: " + error.message());
  // The summary comes last: where it is, the others are of the same drive.
  for (const char* name : {"summary.json", "scale.csv", "turns.csv", "rescale.svg"}) RemoveOldFile(folder / name);
  ReplaceFile(folder / "scale.csv", PoseScaleTable(result));
  ReplaceFile(folder / "turns.csv", TurnScaleTable(result));
  ReplaceFile(folder / "rescale.svg", RescaleSvg(result, fs::path(input).filename().string(), timed));
  ReplaceFile(folder / "summary.json", RescaleJson(result, input));
}

void RunRescale(const RescaleArguments& arguments) {
  RefuseToOverwrite("--out", arguments.out, {arguments.input, arguments.timestamps.value_or("")});
  const TimedTrajectory trajectory = ReadTimedTrajectory(arguments.input, arguments.timestamps, arguments.fps);
  const std::string input = arguments.input.string();
  if (!trajectory.timed && !arguments.quiet) {
    PrintMessage("warning: " + input +
                 ": no times, so the tyres are taken not to slip, which costs up to 40 % of scale; give --fps or "
                 "--timestamps");
  }
  if (trajectory.poses.size() < 2) throw InputError(input + ": holds one pose only; a drive has many");
  const RescaleOptions options = OptionsFrom(arguments, trajectory.timed);
  const RescaleResult result = RescaleTrajectory(options, trajectory.poses);
  if (!result.observable) {
    throw InputError(fmt::format("{}: scale not observable: {}", input, result.reason));
  }
  std::string tum;
  for (const StampedPose& pose : result.metric) tum += TumLine(pose);
  ReplaceFile(arguments.out, tum);
  if (arguments.report) WriteReport(*arguments.report, result, input, trajectory.timed);
  if (const std::string warning = RescaleWarning(result); !warning.empty())
    PrintMessage("warning: " + input + ": " + warning);
  if (!arguments.quiet) PrintText(RescaleText(result));
}

}  // namespace

void AddRescaleCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("rescale", "Give the trajectory of any monocular SLAM its metres.");
  const auto arguments = std::make_shared<RescaleArguments>();
  const CarPrior car;
  command
      ->add_option("FILE", arguments->input,
                   "Trajectory of any scale: TUM, KITTI (12 numbers, or 13 with the frame's number) or EuRoC CSV")
      ->required();
  command->add_option("--lever-arm", arguments->lever_arm, "Metres from the rear axle forward to the camera")
      ->required();
  command->add_option("--lever-arm-sigma", arguments->lever_arm_sigma,
                      fmt::format("Its standard deviation, metres [{}]", kTapeSigma));
  command->add_option("--side-slip", arguments->side_slip,
                      fmt::format("c in L_eff = L - c v^2, s^2/m: how much the rear tyres slip; 0 is a rigid car. "
                                  "Refined from the drive, about {}, where it is not given",
                                  car.side_slip));
  command->add_option(
      "--side-slip-sigma", arguments->side_slip_sigma,
      fmt::format("Its standard deviation, s^2/m; 0: known exactly [{}; with --side-slip {:.0f} % of it]",
                  car.side_slip_sigma, 100 * kGivenSideSlipSigma));
  command->add_option(
      "--camera-rotation", arguments->camera_rotation,
      "How the camera is turned on the car: auto (found from the trajectory), identity, yaw,pitch,roll in "
      "degrees, or a YAML file with them [auto]");
  CLI::Option* fps = command->add_option("--fps", arguments->fps, "Frames per second of a KITTI file");
  command
      ->add_option("--timestamps", arguments->timestamps,
                   "Times of a KITTI file's frames, one a line, s [times.txt beside it]")
      ->excludes(fps);
  command->add_option("--drift", arguments->drift, "auto: the scale may drift along the drive; none: one scale [auto]")
      ->check(CLI::IsMember({"auto", "none"}));
  command->add_option("--out", arguments->out, "The trajectory in metres, TUM [metric.tum]");
  command->add_option("--report", arguments->report,
                      "Folder for scale.csv, turns.csv, summary.json and the picture rescale.svg");
  command->add_flag("--quiet", arguments->quiet, "Print errors only");
  command->footer(
      "Example:\n  turnscale rescale orbslam.tum --lever-arm 1.05 --out metric.tum --report out/\n\n"
      "A drive without a turn does not show its scale: nothing is written then, and the exit code is 2.");
  command->callback([arguments] { RunRescale(*arguments); });
}

}  // namespace turnscale
