// SPDX-License-Identifier: MIT
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "drive_motion.h"
#include "turnscale/base/error.h"
#include "turnscale/calibration/step_gatherer.h"
#include "turnscale/io/calibration_file.h"
#include "turnscale/io/calibration_history.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/speed_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct CalibrateArguments {
  ImageArguments images;
  std::optional<fs::path> trajectory;
  std::optional<fs::path> speed;
  std::optional<double> distance;
  bool metric = false;
  std::optional<double> lever_arm;
  double side_slip = 0.0045;
  bool fit_side_slip = false;
  std::optional<fs::path> history;
  fs::path out = "calibration.yaml";
};

void Check(const CalibrateArguments& arguments) {
  if (arguments.images.input.empty() && !arguments.trajectory) {
    throw InputError("calibrate: give a drive's images, or --trajectory FILE");
  }
  const auto positive = [](const char* option, const std::optional<double>& value) {
    if (!value || (std::isfinite(*value) && *value > 0)) return;
    throw InputError(fmt::format("{} {}: give metres, above 0", option, *value));
  };
  positive("--distance", arguments.distance);
  positive("--lever-arm", arguments.lever_arm);
  if (!(arguments.side_slip >= 0 && arguments.side_slip < 1)) {
    throw InputError(fmt::format(
        "--side-slip {}: give c in s^2/m, from 0 (rigid car) to below 1; cars have about 0.005", arguments.side_slip));
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

// Each step as long as the speeds say; steps that no speeds cover are left out.
std::vector<CameraStep> AtMeasuredSpeed(const std::vector<CameraStep>& steps, const fs::path& path) {
  const SpeedLog log = ReadSpeedFile(path);
  std::vector<CameraStep> metric;
  for (CameraStep step : steps) {
    const std::optional<double> metres = log.Distance(step.begin, step.end);
    if (!metres) continue;
    step.previous_from_current.translation *= *metres / (step.frames * step.previous_from_current.translation.norm());
    metric.push_back(step);
  }
  if (metric.empty()) {
    throw InputError(fmt::format("{}: its times, {:g} to {:g} s, cover none of the drive's, {:g} to {:g} s",
                                 path.string(), log.times.front(), log.times.back(), steps.front().begin,
                                 steps.back().end));
  }
  return metric;
}

std::optional<LeverArmFit> FindLeverArm(const CalibrateArguments& arguments, const DriveMotion& motion,
                                        const std::vector<CameraStep>& steps, const Calibration& found) {
  MetricDrive drive;
  drive.vehicle_from_camera = found.vehicle_from_camera;
  if (arguments.lever_arm) {
    LeverArmFit given;
    given.lever_arm = {*arguments.lever_arm, arguments.side_slip};
    return given;
  }
  if (arguments.speed) {
    drive.steps = AtMeasuredSpeed(steps, *arguments.speed);
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
  options.assumed_side_slip = arguments.side_slip;
  return FitLeverArm({drive}, options);
}

void WriteHistory(const fs::path& path, const std::vector<CameraStep>& steps, const std::string& title) {
  const std::vector<CalibrationMoment> history = CalibrationHistory(steps);
  fs::path picture = path;
  picture.replace_extension(".svg");
  ReplaceFile(path, HistoryCsv(history));
  if (picture != path) ReplaceFile(picture, HistorySvg(history, title));
}

void RunCalibrate(const CalibrateArguments& arguments) {
  Check(arguments);
  const DriveMotion motion = arguments.trajectory
                                 ? MotionFromTrajectory(*arguments.trajectory, arguments.images.timestamps)
                                 : MotionFromImages(arguments.images);
  std::vector<CameraStep> steps;
  CalibrationReport report;
  report.input = motion.input;
  for (const Trajectory& path : motion.stretches) {
    const std::vector<CameraStep> more = StepsAlong(path);
    steps.insert(steps.end(), more.begin(), more.end());
    report.frames += static_cast<int>(path.size());
  }
  try {
    report.calibration = Calibrate(steps);
  } catch (const InputError& error) {
    throw InputError(motion.input + ": " + error.what());
  }
  // Written even where the drive does not suffice: it shows what came when.
  if (arguments.history) WriteHistory(*arguments.history, steps, motion.input);
  if (!report.calibration.observable) {
    throw InputError(fmt::format("{}: {} ({} steps, {:.0f} deg of turning); drive a street corner", motion.input,
                                 report.calibration.problem, report.calibration.steps,
                                 report.calibration.turning * kDegreesPerRadian));
  }
  report.lever_arm = FindLeverArm(arguments, motion, steps, report.calibration);
  ReplaceFile(arguments.out, CalibrationYaml(report));
  if (arguments.images.quiet) return;
  std::string text = CalibrationText(report);
  if (!motion.note.empty()) text += fmt::format("{:<12}{}\n", "note", motion.note);
  WriteStandardOutput(text + fmt::format("{:<12}{}\n", "file", arguments.out.string()));
}

}  // namespace

void AddCalibrateCommand(CLI::App& app) {
  CLI::App* calibrate = app.add_subcommand("calibrate", "Find how the camera is turned on the car, from its motion.");
  auto arguments = std::make_shared<CalibrateArguments>();
  ImageArguments& images = arguments->images;
  CLI::Option* input = calibrate->add_option("input", images.input, "The drive's images, as for run");
  calibrate
      ->add_option("--trajectory", arguments->trajectory,
                   "Instead of images: the camera's path in any unit of length, TUM or KITTI")
      ->excludes(input);
  calibrate->add_option("--camera", images.camera, "Calibration of the camera, as for run");
  CLI::Option* timestamps = calibrate->add_option(
      "--timestamps", images.timestamps, "Times of the frames, one number a line, seconds [times.txt beside them]");
  calibrate->add_option("--fps", images.fps, "Frames per second, where there are no times")->excludes(timestamps);
  calibrate->add_option("--settings", images.settings, "YAML file of settings, as for run");
  calibrate->add_option("--max-frames", images.max_frames, "Stop after this many frames")->check(CLI::PositiveNumber);
  CLI::Option* speed =
      calibrate->add_option("--speed", arguments->speed, "Speeds 'time, m/s', a line each: gives the lever arm too");
  CLI::Option* distance =
      calibrate->add_option("--distance", arguments->distance, "Metres of the whole drive: gives the lever arm too");
  CLI::Option* metric =
      calibrate->add_flag("--metric", arguments->metric, "The trajectory is in metres: gives the lever arm too");
  CLI::Option* lever_arm = calibrate->add_option(
      "--lever-arm", arguments->lever_arm, "Metres from the rear axle forward to the camera, to be kept in the file");
  speed->excludes(distance)->excludes(metric)->excludes(lever_arm);
  distance->excludes(metric)->excludes(lever_arm);
  metric->excludes(lever_arm);
  calibrate
      ->add_option("--side-slip", arguments->side_slip,
                   "c in L_eff = L - c v^2, s^2/m: how much the rear tyres slip; 0 is a rigid car")
      ->capture_default_str();
  calibrate->add_flag("--fit-side-slip", arguments->fit_side_slip,
                      "Find c as well; needs turns at different speeds, and motion in metres");
  calibrate->add_option("--history", arguments->history,
                        "Write what was known when into this CSV file, with a picture (.svg) beside it");
  calibrate->add_option("--out", arguments->out, "File for the calibration")->capture_default_str();
  calibrate->add_flag("--quiet", images.quiet, "Print warnings and errors only");
  calibrate->footer(
      "Example:\n  turnscale calibrate drive.mp4 --camera cam.yaml --out calibration.yaml\n"
      "  turnscale run drive.mp4 --camera cam.yaml --lever-arm 1.45 --camera-rotation calibration.yaml\n\n"
      "Assumed: the car mostly drives forward, with at least one street corner, and the camera is less than a quarter\n"
      "turn from upright (an upside-down camera moves no differently).");
  calibrate->callback([arguments] { RunCalibrate(*arguments); });
}

}  // namespace turnscale
