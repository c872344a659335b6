// SPDX-License-Identifier: MIT
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "common_options.h"
#include "turnscale/commands/rescale_command.h"
#include "turnscale/commands/rescale_report.h"
#include "turnscale/io/height_file.h"
#include "turnscale/io/terminal.h"
#include "turnscale/run/run_writer.h"

namespace turnscale {
namespace {

void Rescale(const RescaleArguments& arguments) {
  const RescaleResult result = ExecuteRescale(arguments, {}).result;
  if (arguments.quiet) return;
  std::string text = RescaleText(result);
  if (!arguments.out.empty()) text += fmt::format("{:<14}{}\n", "file", arguments.out.string());
  if (arguments.report) text += fmt::format("{:<14}{}\n", "report", (*arguments.report / kReportFile).string());
  PrintText(text);
}

}  // namespace

void AddRescaleCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("rescale", "Convert an up-to-scale trajectory of any monocular SLAM to metres.");
  const auto arguments = std::make_shared<RescaleArguments>();
  command
      ->add_option("FILE", arguments->input,
                   "Up-to-scale trajectory: TUM, KITTI (12 numbers per line, or 13 with the frame number) or EuRoC "
                   "CSV; or the folder of a run")
      ->required();
  command->add_option(
      "--lever-arm", arguments->lever_arm,
      "Distance from the rear axle forward to the camera, metres; needed unless --camera-height is given");
  command->add_option("--lever-arm-sigma", arguments->lever_arm_sigma,
                      fmt::format("Standard deviation of --lever-arm, metres [{}]", kTapeSigma));
  AddSideSlipOptions(*command, arguments->side_slip, arguments->side_slip_sigma);
  CLI::Option* heights = command->add_option(
      "--heights", arguments->heights,
      fmt::format(
          "CSV file with heights of the camera above the road, which give the scale between turns: columns time "
          "(seconds, as the trajectory's, which must have times), height and optionally sigma, its standard "
          "deviation [{:.0f} %], both in the trajectory's unit of length",
          100 * kUsualHeightSigma));
  command
      ->add_option(
          "--camera-height", arguments->camera_height,
          fmt::format(
              "Height of the camera above the road, metres, or H,SIGMA with its standard deviation [{:.0f} %]; with "
              "--heights, it determines the scale even without a turn. Estimated in turns if not given",
              100 * kGivenHeightSigma))
      ->needs(heights);
  command->add_option("--camera-rotation", arguments->camera_rotation,
                      "Camera-to-vehicle rotation: auto (estimated from the trajectory); identity; yaw,pitch,roll in "
                      "degrees; or a YAML file, as for run [auto]");
  CLI::Option* fps = command->add_option(
      "--fps", arguments->fps, "Frames per second, of a KITTI trajectory or of one whose times are numbers of frames");
  command
      ->add_option("--timestamps", arguments->timestamps,
                   fmt::format("Times of a KITTI trajectory's frames, {} [times.txt beside it]", kTimesPerLine))
      ->excludes(fps);
  command
      ->add_option("--drift", arguments->drift,
                   "auto: the log-scale is a random walk along the drive; none: constant scale, for loop-closed "
                   "trajectories [auto]")
      ->check(CLI::IsMember({"auto", "none"}));
  command->add_option("--out", arguments->out, "File for the trajectory in metres, TUM [metric.tum]");
  command->add_option("--report", arguments->report,
                      "Folder for report.html, scale.csv, turns.csv, summary.json and rescale.svg");
  command->add_flag("--quiet", arguments->quiet, "Print warnings and errors only");
  command->footer(
      "Example:\n  turnscale rescale orbslam.tum --lever-arm 1.05 --out metric.tum --report rescaled/\n\n"
      "Without a sufficiently slow turn, or heights above the road with --camera-height, the scale is not observable: "
      "nothing\nis written, and the exit code is 2.");
  command->callback([arguments] { Rescale(*arguments); });
}

}  // namespace turnscale
