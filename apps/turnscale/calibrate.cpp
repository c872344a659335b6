// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "argument_checks.h"
#include "commands.h"
#include "drive_camera.h"
#include "drive_source.h"
#include "turnscale/base/error.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/io/calibration_report.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/speed_file.h"
#include "turnscale/io/terminal.h"
#include "turnscale/odometry/options.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct CalibrateArguments {
  ImageArguments images;
  std::optional<fs::path> trajectory;
  std::string axes = "auto";
  std::optional<fs::path> speed;
  std::optional<double> distance;
  bool metric = false;
  std::optional<double> lever_arm;
  std::optional<double> side_slip;
  bool fit_side_slip = false;
  std::optional<fs::path> history;
  fs::path out = "calibration.yaml";

  bool in_metres() const { return speed || distance || metric; }
};

void Check(const CalibrateArguments& arguments) {
  if (arguments.images.inputs.empty() && !arguments.trajectory) {
    throw InputError("calibrate: give the images of a drive, or --trajectory FILE");
  }
  const auto positive = [](const char* option, const std::optional<double>& value) {
    if (!value || (std::isfinite(*value) && *value > 0)) return;
    throw InputError(fmt::format("{} {}: give metres, above 0", option, *value));
  };
  positive("--distance", arguments.distance);
  if (arguments.lever_arm) CheckedLeverArm(*arguments.lever_arm);
  std::vector<fs::path> read = arguments.images.inputs;
  for (const auto& file : {arguments.trajectory, arguments.speed, arguments.images.camera, arguments.images.timestamps,
                           arguments.images.mask}) {
    read.push_back(file.value_or(""));
  }
  RefuseToOverwrite("--out", arguments.out, read);
  RefuseToOverwrite("--history", arguments.history.value_or(""), read);
  if (arguments.side_slip) CheckedSideSlip(*arguments.side_slip);
  if (arguments.fit_side_slip && !arguments.in_metres()) {
    throw InputError("--fit-side-slip: needs metres; give --speed, --distance or --metric");
  }
  if (arguments.side_slip && !arguments.in_metres() && !arguments.lever_arm) {
    throw InputError("--side-slip: needs a lever arm; give --lever-arm, or --speed, --distance or --metric");
  }
  if (arguments.history && arguments.history->extension() == ".svg") {
    throw InputError(fmt::format("--history {}: name a CSV file; the plot (.svg) is written beside it",
                                 arguments.history->string()));
  }
}

double PathLength(const std::vector<Trajectory>& stretches) {
  double length = 0;
  for (const Trajectory& path : stretches) {
    for (size_t i = 1; i < path.size(); ++i) {
      length += (path[i].world_from_camera.translation - path[i - 1].world_from_camera.translation).norm();
    }
  }
  return length;
}

std::vector<CameraStep> Scaled(std::vector<CameraStep> steps, double metres_per_unit) {
  for (CameraStep& step : steps) step.previous_from_current.translation *= metres_per_unit;
  return steps;
}

// Each step scaled to its measured length. Steps without speed measurements, and those below walking speed, whose
// measurements are the least accurate, are left out.
std::vector<CameraStep> AtMeasuredSpeed(const std::vector<CameraStep>& steps, const SpeedLog& log,
                                        const std::string& name) {
  constexpr double kWalking = 1;  // m/s
  std::vector<CameraStep> metric;
  bool covered = false;
  for (CameraStep step : steps) {
    const std::optional<double> metres = log.Distance(step.begin, step.end);
    covered = covered || metres;
    if (!metres || *metres < kWalking * (step.end - step.begin)) continue;
    step.previous_from_current.translation *= *metres / (step.frames * step.previous_from_current.translation.norm());
    metric.push_back(step);
  }
  if (!covered) {
    throw InputError(fmt::format("{}: its times, {:g} to {:g} s, do not overlap the drive's, {:g} to {:g} s", name,
                                 log.times.front(), log.times.back(), steps.front().begin, steps.back().end));
  }
  if (metric.empty()) {
    throw InputError(
        fmt::format("{}: the car stands still, or is slower than {:g} m/s, while the camera moves", name, kWalking));
  }
  return metric;
}

// Checks the source of metric scale before it is used.
void CheckMetres(const CalibrateArguments& arguments, const DriveMotion& motion) {
  if (arguments.distance && !motion.incomplete.empty()) {
    throw InputError(fmt::format("--distance: cannot be applied to {}: {}; give --speed, or a drive without gaps",
                                 motion.input, motion.incomplete));
  }
  if (motion.timed) return;
  const auto refuse = [&](const char* option) {
    throw InputError(fmt::format("{}: {} has no timestamps; give --fps or --timestamps", option, motion.input));
  };
  if (arguments.speed) refuse("--speed");
  if (arguments.fit_side_slip) refuse("--fit-side-slip");
  if (arguments.in_metres() && arguments.side_slip.value_or(0) > 0) refuse("--side-slip");
}

// The assumed c: without times no speed is known, and slip is neglected.
double AssumedSlip(const CalibrateArguments& arguments, const DriveMotion& motion) {
  if (arguments.side_slip) return *arguments.side_slip;
  return motion.timed || arguments.lever_arm ? VehicleOptions().side_slip : 0;
}

std::optional<LeverArmFit> FindLeverArm(const CalibrateArguments& arguments, const std::optional<SpeedLog>& speeds,
                                        const DriveMotion& motion, const std::vector<CameraStep>& steps,
                                        const Calibration& found) {
  const double slip = AssumedSlip(arguments, motion);
  if (arguments.lever_arm) {
    LeverArmFit given;
    given.lever_arm = {*arguments.lever_arm, slip};
    return given;
  }
  MetricDrive drive;
  drive.vehicle_from_camera = found.vehicle_from_camera;
  if (speeds) {
    drive.steps = AtMeasuredSpeed(steps, *speeds, arguments.speed->string());
  } else if (arguments.distance) {
    drive.steps = Scaled(steps, *arguments.distance / PathLength(motion.stretches));
  } else if (arguments.metric) {
    drive.steps = steps;
  } else {
    return std::nullopt;
  }
  int reversed = 0;
  drive.steps = DrivenForward(std::move(drive.steps), reversed);
  LeverArmFitOptions options;
  options.side_slip = arguments.fit_side_slip;
  options.assumed_side_slip = slip;
  try {
    return FitLeverArm({drive}, options);
  } catch (const InputError& error) {
    throw InputError(motion.input + ": lever arm not estimated: " + error.what());
  }
}

void WriteHistory(const fs::path& path, const std::vector<CameraStep>& steps, const std::string& title) {
  const std::vector<CalibrationMoment> history = CalibrationHistory(steps);
  fs::path picture = path;
  picture.replace_extension(".svg");
  ReplaceFile(path, HistoryCsv(history));
  if (picture != path) ReplaceFile(picture, HistorySvg(history, title));
}

DriveMotion ReadMotion(const CalibrateArguments& arguments) {
  if (!arguments.trajectory) return MotionFromImages(arguments.images);
  const ImageArguments& images = arguments.images;
  std::optional<AxisConvention> axes;
  if (arguments.axes == "camera") axes = AxisConvention::kCamera;
  if (arguments.axes == "flu") axes = AxisConvention::kForwardLeftUp;
  if (arguments.axes == "frd") axes = AxisConvention::kForwardRightDown;
  return MotionFromTrajectory(*arguments.trajectory, images.timestamps, images.fps, axes);
}

Calibration CalibrateDrive(const std::vector<CameraStep>& steps, const std::string& input) {
  try {
    return Calibrate(steps);
  } catch (const InputError& error) {
    throw InputError(input + ": " + error.what());
  }
}

void CalibrateMotion(const CalibrateArguments& arguments, const std::optional<SpeedLog>& speeds,
                     const DriveMotion& motion) {
  CheckMetres(arguments, motion);
  const std::vector<CameraStep> steps = StepsAlong(motion.stretches);
  CalibrationReport report;
  report.input = motion.input;
  for (const Trajectory& path : motion.stretches) report.frames += static_cast<int>(path.size());
  report.calibration = CalibrateDrive(steps, motion.input);
  Attempts attempts;
  // Written even if the drive does not suffice: it shows the estimate over time.
  if (arguments.history) attempts.Try([&] { WriteHistory(*arguments.history, steps, motion.input); });
  if (!report.calibration.observable) {
    throw InputError(fmt::format("{}: {} ({} steps, {:.0f} deg of turning); use a drive with a street corner",
                                 motion.input, report.calibration.problem, report.calibration.steps,
                                 report.calibration.turning * kDegreesPerRadian));
  }
  // The rotation is valid even if the lever arm cannot be estimated.
  attempts.Try([&] { ReplaceFile(arguments.out, CalibrationYaml(report)); });
  try {
    report.lever_arm = FindLeverArm(arguments, speeds, motion, steps, report.calibration);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{} (the camera-to-vehicle rotation is in {})", error.what(), arguments.out.string()));
  }
  attempts.Try([&] { ReplaceFile(arguments.out, CalibrationYaml(report)); });
  attempts.RethrowFirst();
  if (arguments.images.quiet) return;
  std::string text = CalibrationText(report);
  if (!motion.note.empty()) text += fmt::format("{:<12}{}\n", "note", motion.note);
  PrintText(text + fmt::format("{:<12}{}\n", "file", arguments.out.string()));
}

// Returns the exit code.
int RunCalibrate(const CalibrateArguments& arguments) {
  Check(arguments);
  // Before the images, which may take hours.
  const std::optional<SpeedLog> speeds =
      arguments.speed ? std::optional(ReadSpeedFile(*arguments.speed)) : std::nullopt;
  const DriveMotion motion = ReadMotion(arguments);
  if (!motion.stopped) {
    CalibrateMotion(arguments, speeds, motion);
    return 0;
  }
  std::string outcome = "the rotation estimated so far is in " + arguments.out.string();
  try {
    CalibrateMotion(arguments, speeds, motion);
  } catch (const InputError& error) {
    outcome = error.what();
  }
  return Report({motion.stopped->exit_code, motion.stopped->message + "; " + outcome});
}

}  // namespace

void AddCalibrateCommand(CLI::App& app) {
  CLI::App* calibrate =
      app.add_subcommand("calibrate", "Estimate the camera-to-vehicle rotation from the camera's motion.");
  auto arguments = std::make_shared<CalibrateArguments>();
  ImageArguments& images = arguments->images;
  CLI::Option* input = calibrate->add_option("input", images.inputs, "Images of the drive, as for run");
  CLI::Option* trajectory = calibrate
                                ->add_option("--trajectory", arguments->trajectory,
                                             "Instead of images: camera trajectory in any unit of length, TUM, KITTI "
                                             "or EuRoC")
                                ->excludes(input);
  calibrate
      ->add_option(
          "--axes", arguments->axes,
          "Axes of the trajectory's poses: camera, or vehicle axes forward-left-up (flu) or forward-right-down "
          "(frd)")
      ->check(CLI::IsMember({"auto", "camera", "flu", "frd"}))
      ->capture_default_str()
      ->needs(trajectory);
  AddCameraOptions(*calibrate, images);
  for (const char* option : {"--camera", "--fov", "--camera-refine"})
    calibrate->get_option(option)->excludes(trajectory);
  CLI::Option* timestamps = calibrate->add_option(
      "--timestamps", images.timestamps,
      "Times of the frames in seconds, one per line [times.txt in the input folder, or beside the trajectory]");
  calibrate->add_option("--fps", images.fps, "Frames per second; overrides times.txt and a video's own time stamps")
      ->excludes(timestamps);
  calibrate->add_option("--settings", images.settings, "YAML file with settings, as for run")->excludes(trajectory);
  AddPartOptions(*calibrate, images);
  for (const char* option : {"--topic", "--start", "--end", "--mask"})
    calibrate->get_option(option)->excludes(trajectory);
  CLI::Option* max_frames = calibrate->add_option("--max-frames", images.max_frames, "Stop after this many frames")
                                ->check(CLI::Range(1, 1'000'000'000))
                                ->excludes(trajectory);
  CLI::Option* speed = calibrate->add_option(
      "--speed", arguments->speed, "File with one 'time, speed' per line, s and m/s: estimate the lever arm too");
  CLI::Option* distance = calibrate->add_option("--distance", arguments->distance,
                                                "Path length of the drive, metres: estimate the lever arm too");
  CLI::Option* metric =
      calibrate->add_flag("--metric", arguments->metric, "The trajectory is in metres: estimate the lever arm too")
          ->needs(trajectory);
  CLI::Option* lever_arm = calibrate->add_option(
      "--lever-arm", arguments->lever_arm,
      "Known lever arm, metres from the rear axle forward to the camera; recorded in the output file, for "
      "run --vehicle");
  speed->excludes(distance)->excludes(metric)->excludes(lever_arm);
  distance->excludes(metric)->excludes(lever_arm)->excludes(max_frames);
  metric->excludes(lever_arm);
  CLI::Option* side_slip = calibrate->add_option(
      "--side-slip", arguments->side_slip,
      fmt::format("Slip-angle coefficient c in L_eff = L - c v^2, s^2/m; 0: no slip [{}; 0 without timestamps]",
                  VehicleOptions().side_slip));
  calibrate
      ->add_flag("--fit-side-slip", arguments->fit_side_slip,
                 "Estimate c too; needs turns at different speeds, and --speed, --distance or --metric")
      ->excludes(side_slip);
  calibrate->add_option("--history", arguments->history,
                        "Write the estimate over time to this CSV file, and plot it (.svg beside it)");
  calibrate->add_option("--out", arguments->out, "File for the calibration")->capture_default_str();
  calibrate->add_flag("--quiet", images.quiet, "Print warnings and errors only");
  calibrate->footer(
      "Example:\n  turnscale calibrate drive.mp4 --camera camera.yaml --out calibration.yaml\n"
      "  turnscale run drive.mp4 --camera camera.yaml --lever-arm 1.45 --camera-rotation calibration.yaml\n\n"
      "Assumptions: the car mostly drives forward, through at least one street corner, and the camera is upright\n"
      "to within 90 degrees of roll (motion alone cannot distinguish an upside-down camera from an upright one).");
  calibrate->callback([arguments] {
    if (const int exit_code = RunCalibrate(*arguments); exit_code != 0) throw CLI::RuntimeError(exit_code);
  });
}

}  // namespace turnscale
