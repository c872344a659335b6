// SPDX-License-Identifier: MIT
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "car_arguments.h"
#include "commands.h"
#include "drive_images.h"
#include "interrupt.h"
#include "turnscale/base/error.h"
#include "turnscale/io/message.h"
#include "turnscale/io/progress.h"
#include "turnscale/io/run_drive.h"
#include "turnscale/io/settings.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  ImageArguments images;
  std::optional<double> lever_arm;
  std::optional<double> lever_arm_sigma;
  std::optional<double> side_slip;
  std::optional<double> side_slip_sigma;
  std::string camera_rotation;
  std::optional<std::string> method;
  std::string frame = "camera";
  std::optional<int> threads;
  fs::path out = "out";
};

// The settings file first, what the command line says over it. Checked here so that messages name the option.
OdometryOptions OptionsFrom(const RunArguments& arguments) {
  OdometryOptions options = arguments.images.settings ? ReadSettings(*arguments.images.settings) : OdometryOptions();
  if (arguments.lever_arm) options.vehicle.lever_arm = CheckedLeverArm(*arguments.lever_arm);
  if (arguments.lever_arm_sigma) options.vehicle.lever_arm_sigma = CheckedLeverArmSigma(*arguments.lever_arm_sigma);
  if (arguments.side_slip) {
    options.vehicle.side_slip = CheckedSideSlip(*arguments.side_slip);
    options.vehicle.side_slip_sigma = kGivenSideSlipSigma * *arguments.side_slip;
  }
  if (arguments.side_slip_sigma) options.vehicle.side_slip_sigma = CheckedSideSlipSigma(*arguments.side_slip_sigma);
  if (arguments.camera_rotation == "auto") {
    options.vehicle.calibrate_camera = true;
  } else if (!arguments.camera_rotation.empty()) {
    options.vehicle.vehicle_from_camera = ReadCameraRotation(arguments.camera_rotation);
    options.vehicle.calibrate_camera = false;
  }
  if (arguments.method)
    options.scale.method = *arguments.method == "paper"   ? ScaleMethod::kPaper
                           : *arguments.method == "turns" ? ScaleMethod::kTurns
                                                          : ScaleMethod::kSmoothed;
  if (arguments.threads) {
    if (*arguments.threads < 1) throw InputError(fmt::format("--threads {}: give at least 1", *arguments.threads));
    options.threads = *arguments.threads;
  }
  options.Check();
  return options;
}

RunSummary BeforeTheDrive(const RunArguments& arguments, const OdometryOptions& options, const DriveImages& images) {
  RunSummary summary;
  summary.version = TURNSCALE_VERSION;
  summary.input = arguments.images.input.string();
  summary.camera = images.camera_file.string();
  summary.pose_frame = arguments.frame;
  summary.folder = arguments.out.string();
  summary.vehicle = options.vehicle;
  return summary;
}

// Says what went wrong; returns the exit code.
int ReportEnd(const RunEnd& end) {
  const std::string kept = "; what was computed is in " + end.summary.folder;
  if (end.failures.empty() && end.interrupted) return Report({kInterruptedExitCode, end.summary.stopped + kept});
  if (end.failures.empty()) return 0;
  Failure first = FailureOf(end.failures.front());
  std::set<std::string> said = {first.message};
  for (const std::exception_ptr& failure : end.failures) {
    const std::string message = FailureOf(failure).message;
    if (said.insert(message).second) PrintMessage("warning: " + message);
  }
  first.message += kept;
  return Report(first);
}

// Returns the exit code.
int RunImages(const RunArguments& arguments) {
  const OdometryOptions options = OptionsFrom(arguments);
  DriveImages images(arguments.images);
  Odometry odometry(options, images.camera);
  Progress progress(images.expected, arguments.images.quiet);
  bool begun = false;
  const auto next = [&] {
    std::optional<SourceFrame> frame = images.source.Next();
    if (begun) return frame;
    begun = true;
    // From here on there is something to keep.
    CatchInterrupts();
    if (const std::string doubt = frame ? DoubtOf(images, frame->gray) : ""; !doubt.empty()) progress.Warn(doubt);
    return frame;
  };
  const PoseFrame shown = arguments.frame == "vehicle" ? PoseFrame::kVehicle : PoseFrame::kCamera;
  const DriveToRun drive = {next,
                            Interrupted,
                            [&] { return images.source.count(); },
                            arguments.images.max_frames,
                            {arguments.out, shown, options.vehicle},
                            BeforeTheDrive(arguments, options, images)};
  const RunEnd end = RunDrive(drive, odometry, progress);
  if (end.failures.empty() && !arguments.images.quiet) PrintText(SummaryText(end.summary));
  return ReportEnd(end);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  CLI::App* run = app.add_subcommand("run", "Compute the path of a drive from its images.");
  auto arguments = std::make_shared<RunArguments>();
  run->add_option("input", arguments->images.input,
                  "A KITTI folder (image_0/ or images/, calib.txt, times.txt), a folder of images, or a video")
      ->required();
  run->add_option(
      "--camera", arguments->images.camera,
      "Calibration: KITTI calib.txt, OpenCV, ORB-SLAM or Kalibr YAML [calib.txt or camera.yaml in the input folder]");
  CLI::Option* timestamps =
      run->add_option("--timestamps", arguments->images.timestamps, "Times of the frames, one number a line, seconds");
  run->add_option("--fps", arguments->images.fps, "Frames per second, where there are no times")->excludes(timestamps);
  run->add_option("--lever-arm", arguments->lever_arm,
                  "Metres from the rear axle forward to the camera; without it the path is up to scale");
  run->add_option("--lever-arm-sigma", arguments->lever_arm_sigma,
                  fmt::format("Its standard deviation, metres [{}]", kTapeSigma));
  run->add_option("--side-slip", arguments->side_slip,
                  fmt::format("c in L_eff = L - c v^2, s^2/m: how much the rear tyres slip; 0 is a rigid car. Refined "
                              "from the drive, about {}, where it is not given",
                              kUsualSideSlip));
  run->add_option("--side-slip-sigma", arguments->side_slip_sigma,
                  fmt::format("Its standard deviation, s^2/m; 0: known exactly [{}; with --side-slip {:.0f} % of it]",
                              kUsualSideSlipSigma, 100 * kGivenSideSlipSigma));
  run->add_option(
      "--camera-rotation", arguments->camera_rotation,
      "How the camera is turned on the car: yaw,pitch,roll in degrees (right, up, right side down), a YAML file with "
      "yaw_deg, pitch_deg, roll_deg such as calibrate's, or auto: find it on the way [auto]");
  run->add_option(
         "--method", arguments->method,
         "How the path becomes metric: smoothed, what all turns together say along the drive; turns, each turn "
         "held at what it says by itself; paper, each step of a turn held at what it says (22) [smoothed]")
      ->check(CLI::IsMember({"smoothed", "turns", "paper"}));
  run->add_option("--frame", arguments->frame, "Whose poses are written")
      ->check(CLI::IsMember({"camera", "vehicle"}))
      ->capture_default_str();
  run->add_option("--threads", arguments->threads, "Threads for image operations; the result does not depend on it");
  run->add_option("--settings", arguments->images.settings,
                  "YAML file of settings, such as the settings.yaml of another run");
  run->add_option("--out", arguments->out, "Folder for the results")->capture_default_str();
  run->add_option("--max-frames", arguments->images.max_frames, "Stop after this many frames")
      ->check(CLI::Range(1, 1'000'000'000));
  run->add_flag("--quiet", arguments->images.quiet, "Print warnings and errors only");
  run->footer(
      "Example:\n  turnscale run drive.mp4 --camera cam.yaml --lever-arm 1.45 --out out/drive\n\n"
      "The folder then holds trajectory.tum and trajectory.kitti.txt (refined, every frame), live.tum (as known at "
      "each\n"
      "moment), trajectory.csv, turns.csv, map.ply, settings.yaml and summary.json. Ctrl-C stops after the current "
      "frame\n"
      "and keeps what was computed (exit code 130).");
  run->callback([arguments] {
    if (const int exit_code = RunImages(*arguments); exit_code != 0) throw CLI::RuntimeError(exit_code);
  });
}

}  // namespace turnscale
