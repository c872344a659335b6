// SPDX-License-Identifier: MIT
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "common_options.h"
#include "interrupt.h"
#include "turnscale/commands/calibrate_command.h"
#include "turnscale/io/terminal.h"
#include "turnscale/odometry/options.h"

namespace turnscale {
namespace {

// Returns the exit code.
int RunCalibrate(const CalibrateArguments& arguments) {
  // A trajectory is read at once: what is interrupted may be the writing of files.
  if (!arguments.trajectory) EndOnInterrupts();
  CommandHooks hooks;
  hooks.interrupted = Interrupted;
  hooks.begun = CatchInterrupts;
  const CalibrateOutcome outcome = ExecuteCalibrate(arguments, hooks);
  if (outcome.report && !arguments.images.quiet) {
    std::string text = CalibrationText(*outcome.report);
    if (!outcome.note.empty()) text += fmt::format("{:<12}{}\n", "note", outcome.note);
    PrintText(text + fmt::format("{:<12}{}\n", "file", arguments.out.string()));
  }
  return outcome.stopped ? Report(*outcome.stopped) : 0;
}

}  // namespace

void AddCalibrateCommand(CLI::App& app) {
  CLI::App* calibrate =
      app.add_subcommand("calibrate", "Estimate the camera-to-vehicle rotation from the camera's motion.");
  auto arguments = std::make_shared<CalibrateArguments>();
  ImageArguments& images = arguments->images;
  calibrate->add_option("input", images.inputs, "Images of the drive, as for run");
  calibrate->add_option("--trajectory", arguments->trajectory,
                        "Instead of images: camera trajectory in any unit of length, TUM, KITTI "
                        "or EuRoC, or the folder of a run");
  calibrate
      ->add_option(
          "--axes", arguments->axes,
          "Axes of the trajectory's poses: camera, or vehicle axes forward-left-up (flu) or forward-right-down "
          "(frd)")
      ->check(CLI::IsMember({"auto", "camera", "flu", "frd"}))
      ->capture_default_str();
  AddCameraOptions(*calibrate, images);
  calibrate->add_option(
      "--timestamps", images.timestamps,
      fmt::format("Times of the frames, {} [times.txt in the input folder, or beside the trajectory]", kTimesPerLine));
  calibrate->add_option(
      "--fps", images.fps,
      "Frames per second; overrides times.txt, a video's own time stamps and the header stamps of a bag");
  calibrate->add_option("--settings", images.settings, "YAML file with settings, as for run");
  AddPartOptions(*calibrate, images);
  calibrate->add_option("--max-frames", images.max_frames, "Stop after this many frames")
      ->check(CLI::Range(1, 1'000'000'000));
  calibrate->add_option(
      "--speed", arguments->speed,
      "File with one 'time, speed' per line, s and m/s, or in the unit that its first line names, such as "
      "'time, speed_kmh': estimate the lever arm too");
  calibrate->add_option("--distance", arguments->distance,
                        "Path length of the drive, metres: estimate the lever arm too");
  calibrate->add_flag("--metric", arguments->metric, "The trajectory is in metres: estimate the lever arm too");
  calibrate->add_option(
      "--lever-arm", arguments->lever_arm,
      "Known lever arm, metres from the rear axle forward to the camera; recorded in the output file, for "
      "run --vehicle");
  calibrate->add_option(
      "--side-slip", arguments->side_slip,
      fmt::format("Side slip of the rear axle: its slip angle per lateral acceleration, rad per m/s^2 (= s^2/m); c in "
                  "L_eff = L - c v^2; 0: none [{}; 0 without timestamps]",
                  VehicleOptions().side_slip));
  calibrate->add_flag("--fit-side-slip", arguments->fit_side_slip,
                      "Estimate c too; needs turns at different speeds, and --speed, --distance or --metric");
  calibrate->add_option("--history", arguments->history,
                        "Write the estimate over time to this CSV file, and plot it (.svg beside it)");
  calibrate->add_option("--out", arguments->out, "File for the calibration")->capture_default_str();
  calibrate->add_flag("--quiet", images.quiet, "Print warnings and errors only");
  DeclareRules(CalibrateRules(), *calibrate);
  calibrate->footer(
      "Example:\n  turnscale calibrate drive.mp4 --camera camera.yaml --out calibration.yaml\n"
      "  turnscale run drive.mp4 --camera camera.yaml --lever-arm 1.45 --camera-rotation calibration.yaml\n\n"
      "Assumptions: the car mostly drives forward, through at least one street corner, and the camera is upright\n"
      "to within 90 degrees of roll (motion alone cannot distinguish an upside-down camera from an upright one; see "
      "--rotate).");
  calibrate->callback([arguments] {
    if (const int exit_code = RunCalibrate(*arguments); exit_code != 0) throw CLI::RuntimeError(exit_code);
  });
}

}  // namespace turnscale
