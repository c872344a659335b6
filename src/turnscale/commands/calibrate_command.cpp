// SPDX-License-Identifier: MIT
#include "turnscale/commands/calibrate_command.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/commands/argument_checks.h"
#include "turnscale/commands/run_of_trajectory.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/speed_file.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/odometry/options.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

void CheckTogether(const CalibrateArguments& arguments) {
  const ImageArguments& images = arguments.images;
  CheckChoice("--axes", arguments.axes, {"auto", "camera", "flu", "frd"});
  CheckTogether(CalibrateRules(), {{"input", !images.inputs.empty()},
                                   {"--trajectory", arguments.trajectory.has_value()},
                                   {"--axes", arguments.axes != "auto"},
                                   {"--camera", images.camera || images.camera_object},
                                   {"--fov", images.field_of_view.has_value()},
                                   {"--camera-refine", images.refine_camera},
                                   {"--timestamps", images.timestamps.has_value()},
                                   {"--fps", images.fps.has_value()},
                                   {"--settings", images.settings.has_value()},
                                   {"--topic", !images.topic.empty()},
                                   {"--start", !images.start.empty()},
                                   {"--end", !images.end.empty()},
                                   {"--rotate", images.rotate != 0},
                                   {"--mask", images.mask.has_value()},
                                   {"--max-frames", images.max_frames.has_value()},
                                   {"--speed", arguments.speed.has_value()},
                                   {"--distance", arguments.distance.has_value()},
                                   {"--metric", arguments.metric},
                                   {"--lever-arm", arguments.lever_arm.has_value()},
                                   {"--side-slip", arguments.side_slip.has_value()},
                                   {"--fit-side-slip", arguments.fit_side_slip}});
}

// What is read besides the images, also what FindDrive and FindPoseTimes may find by themselves.
std::vector<fs::path> FilesRead(const CalibrateArguments& arguments) {
  const ImageArguments& images = arguments.images;
  std::vector<fs::path> files = images.inputs;
  for (const std::optional<fs::path>& file :
       {arguments.trajectory, arguments.speed, images.camera, images.timestamps, images.settings, images.mask})
    files.push_back(file.value_or(""));
  for (const fs::path& input : images.inputs)
    for (const char* name : {"calib.txt", "camera.yaml", "times.txt"}) files.push_back(input / name);
  if (arguments.trajectory) files.push_back(FindPoseTimes(*arguments.trajectory));
  return files;
}

// The plot beside the history.
fs::path PictureOf(fs::path history) { return history.replace_extension(".svg"); }

void Check(const CalibrateArguments& arguments) {
  CheckTogether(arguments);
  if (arguments.images.inputs.empty() && !arguments.trajectory) {
    throw InputError("calibrate: give the images of a drive, or --trajectory FILE");
  }
  const auto positive = [](const char* option, const std::optional<double>& value) {
    if (!value || (std::isfinite(*value) && *value > 0)) return;
    throw InputError(fmt::format("{} {}: give metres, above 0", option, *value));
  };
  positive("--distance", arguments.distance);
  if (arguments.lever_arm) CheckedLeverArm(*arguments.lever_arm);
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
  std::vector<NamedOutput> outputs{{"--out", arguments.out}};
  if (arguments.history) {
    outputs.push_back({"--history", *arguments.history});
    outputs.push_back({"--history", PictureOf(*arguments.history)});
  }
  CheckOutputs(outputs, FilesRead(arguments));
  RefuseResultsOfRun(outputs);
}

// Between poses some time apart: the noise of those of a standing car would add up.
double PathLength(const std::vector<Trajectory>& stretches) {
  constexpr double kSeconds = 0.3;
  double length = 0;
  for (const Trajectory& path : stretches) {
    const StampedPose* last = &path.front();
    for (const StampedPose& pose : path) {
      if (pose.time - last->time < kSeconds && &pose != &path.back()) continue;
      length += (pose.world_from_camera.translation - last->world_from_camera.translation).norm();
      last = &pose;
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

// The fastest speed shows whether it is the right one, and so does the lever arm.
std::string AssumedUnit(const std::string& name, const SpeedLog& log, const std::optional<LeverArmFit>& fit) {
  constexpr double kLongest = 3.5;  // m; the wheelbase of a van
  const double fastest = std::ranges::max(log.speeds);
  std::string text = fmt::format("{} names no unit of speed: m/s assumed, so the fastest is {:.1f} m/s ({:.0f} km/h)",
                                 name, fastest, 3.6 * fastest);
  if (fit && fit->lever_arm.length > kLongest)
    text += fmt::format(
        "; a lever arm of {:.1f} m is too long for a car: if the speeds are in km/h, name the column speed_kmh",
        fit->lever_arm.length);
  return text;
}

// The distance is that of the whole path. Why a drive was stopped is said elsewhere.
void CheckDistance(const CalibrateArguments& arguments, const DriveMotion& motion) {
  if (!arguments.distance || motion.incomplete.empty() || motion.stopped) return;
  throw InputError(fmt::format("--distance: cannot be applied to {}: {}; give --speed, or a drive without gaps",
                               motion.input, motion.incomplete));
}

// Checks the times that the source of metric scale needs, before it is used.
void CheckMetres(const CalibrateArguments& arguments, const DriveMotion& motion) {
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

// That which a run would take for the same c. Where slip is neglected, none: the lever arm is that of the drive's
// speed.
double AssumedSlipSigma(const CalibrateArguments& arguments, const DriveMotion& motion) {
  if (arguments.side_slip) return SigmaOfGivenSideSlip(*arguments.side_slip);
  return motion.timed || arguments.lever_arm ? VehicleOptions().side_slip_sigma : 0;
}

std::string SourceOfMetres(const CalibrateArguments& arguments) {
  if (arguments.speed) return "--speed " + arguments.speed->string();
  if (arguments.distance) return fmt::format("--distance {}", *arguments.distance);
  return "--metric (the trajectory may not be in metres)";
}

std::optional<LeverArmFit> FindLeverArm(const CalibrateArguments& arguments, const std::optional<SpeedLog>& speeds,
                                        const DriveMotion& motion, const std::vector<CameraStep>& steps,
                                        const Calibration& found) {
  const double slip = AssumedSlip(arguments, motion);
  const double slip_sigma = AssumedSlipSigma(arguments, motion);
  if (arguments.lever_arm) {
    LeverArmFit given;
    given.lever_arm = {*arguments.lever_arm, slip};
    given.sigma_side_slip = slip_sigma;
    return given;
  }
  CheckDistance(arguments, motion);
  if (arguments.distance && motion.stopped)
    throw InputError("--distance: needs the whole drive; no lever arm is estimated");
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
  LeverArmFitOptions options;
  options.side_slip = arguments.fit_side_slip;
  options.assumed_side_slip = slip;
  options.assumed_side_slip_sigma = slip_sigma;
  options.intrinsics_sigma = motion.calibration_sigma;
  options.source_of_metres = SourceOfMetres(arguments);
  try {
    return FitLeverArm({drive}, options);
  } catch (const InputError& error) {
    throw InputError(motion.input + ": lever arm not estimated: " + error.what());
  }
}

void WriteHistory(const fs::path& path, const std::vector<CalibrationMoment>& history, const std::string& title) {
  const fs::path picture = PictureOf(path);
  ReplaceFile(path, HistoryCsv(history));
  if (picture != path) ReplaceFile(picture, HistorySvg(history, title));
}

DriveMotion ReadMotion(const CalibrateArguments& arguments, const CommandHooks& hooks) {
  if (!arguments.trajectory) return MotionFromImages(arguments.images, hooks);
  const ImageArguments& images = arguments.images;
  if (IsOfRearAxle(*arguments.trajectory))
    throw InputError(arguments.trajectory->string() +
                     ": the poses are those of the rear axle, not of the camera; run again without --frame vehicle");
  std::optional<AxisConvention> axes;
  if (arguments.axes == "camera") axes = AxisConvention::kCamera;
  if (arguments.axes == "flu") axes = AxisConvention::kForwardLeftUp;
  if (arguments.axes == "frd") axes = AxisConvention::kForwardRightDown;
  return MotionFromTrajectory(*arguments.trajectory, images.timestamps, images.fps, axes);
}

Calibration CalibrateDrive(const CalibrateArguments& arguments, const DriveMotion& motion,
                           const std::vector<CameraStep>& steps) {
  try {
    return Calibrate(steps);
  } catch (const InputError& error) {
    // What is missing of the drive may be its motion.
    CheckDistance(arguments, motion);
    throw InputError(motion.input + ": " + error.what());
  }
}

CalibrationReport CalibrateMotion(const CalibrateArguments& arguments, const std::optional<SpeedLog>& speeds,
                                  const DriveMotion& motion, std::vector<CalibrationMoment>& history) {
  CheckMetres(arguments, motion);
  const std::vector<CameraStep> steps = StepsAlong(motion.stretches);
  CalibrationReport report;
  report.input = motion.input;
  for (const Trajectory& path : motion.stretches) report.frames += static_cast<int>(path.size());
  report.calibration = CalibrateDrive(arguments, motion, steps);
  Attempts attempts;
  // Written even if the drive does not suffice: it shows the estimate over time.
  attempts.Try([&] {
    if (arguments.history || arguments.keep_history) history = CalibrationHistory(steps);
    if (arguments.history) WriteHistory(*arguments.history, history, motion.input);
  });
  if (!report.calibration.observable) {
    // What is missing of the drive may be its turns.
    CheckDistance(arguments, motion);
    attempts.RethrowFirst();
    throw InputError(fmt::format("{}: {} ({} steps, {:.0f} deg of turning); use a drive with a street corner",
                                 motion.input, report.calibration.problem, report.calibration.steps,
                                 report.calibration.turning * kDegreesPerRadian));
  }
  const auto write = [&] {
    if (!arguments.out.empty()) ReplaceFile(arguments.out, CalibrationYaml(report));
  };
  // The rotation is valid even if the lever arm cannot be estimated.
  attempts.Try(write);
  try {
    report.lever_arm = FindLeverArm(arguments, speeds, motion, steps, report.calibration);
  } catch (const InputError& error) {
    attempts.RethrowFirst();
    if (arguments.out.empty()) throw;
    throw InputError(fmt::format("{} (the camera-to-vehicle rotation is in {})", error.what(), arguments.out.string()));
  }
  attempts.Try(write);
  attempts.RethrowFirst();
  return report;
}

}  // namespace

OptionRules CalibrateRules() {
  OptionRules rules = {.exclusive = {{"--timestamps", "--fps"},
                                     {"--speed", "--distance"},
                                     {"--speed", "--metric"},
                                     {"--speed", "--lever-arm"},
                                     {"--distance", "--metric"},
                                     {"--distance", "--lever-arm"},
                                     {"--metric", "--lever-arm"},
                                     {"--distance", "--max-frames"},
                                     {"--side-slip", "--fit-side-slip"}},
                       .needs = {{"--axes", "--trajectory"}, {"--metric", "--trajectory"}}};
  for (const char* of_images : {"input", "--camera", "--fov", "--camera-refine", "--settings", "--topic", "--start",
                                "--end", "--rotate", "--mask", "--max-frames"})
    rules.exclusive.push_back({of_images, "--trajectory"});
  return rules;
}

CalibrateOutcome ExecuteCalibrate(const CalibrateArguments& given, const CommandHooks& hooks) {
  CalibrateArguments arguments = given;
  if (given.trajectory) arguments.trajectory = TrajectoryOf(*given.trajectory);
  Check(arguments);
  // Before the images, which may take hours.
  if (!arguments.out.empty()) CheckOutputFile(arguments.out);
  if (arguments.history) CheckOutputFile(*arguments.history);
  const std::optional<SpeedLog> speeds =
      arguments.speed ? std::optional(ReadSpeedFile(*arguments.speed)) : std::nullopt;
  const DriveMotion motion = ReadMotion(arguments, hooks);
  CalibrateOutcome outcome;
  outcome.note = motion.note;
  outcome.stopped = motion.stopped;
  if (!motion.stopped) {
    outcome.report = CalibrateMotion(arguments, speeds, motion, outcome.history);
  } else {
    std::string result = "the rotation estimated so far is in " + arguments.out.string();
    if (arguments.out.empty()) result = "the rotation is not written";
    try {
      outcome.report = CalibrateMotion(arguments, speeds, motion, outcome.history);
    } catch (const InputError& error) {
      result = error.what();
    }
    outcome.stopped->message += "; " + result;
  }
  if (speeds && !speeds->names_unit)
    outcome.note +=
        (outcome.note.empty() ? "" : "; ") +
        AssumedUnit(arguments.speed->string(), *speeds, outcome.report ? outcome.report->lever_arm : std::nullopt);
  return outcome;
}

}  // namespace turnscale
