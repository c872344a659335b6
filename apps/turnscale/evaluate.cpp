// SPDX-License-Identifier: MIT
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "common_options.h"
#include "turnscale/commands/evaluate_command.h"
#include "turnscale/commands/evaluation_report.h"
#include "turnscale/io/terminal.h"

namespace turnscale {
namespace {

void RunEvaluate(const EvaluateArguments& arguments) {
  const Comparison comparison = ExecuteEvaluate(arguments, {});
  if (arguments.json == "-") {
    WriteStandardOutput(ComparisonJson(comparison));
  } else {
    PrintText(EvaluationTable(comparison.evaluation, comparison.sources));
  }
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  auto* command = app.add_subcommand("evaluate", "Evaluate a trajectory against ground truth.");
  const auto arguments = std::make_shared<EvaluateArguments>();
  command
      ->add_option("ESTIMATE", arguments->estimate,
                   "Estimated trajectory: TUM, EuRoC or KITTI file, or the folder of a run")
      ->required();
  command->add_option("GROUND_TRUTH", arguments->ground_truth, "Ground-truth trajectory: likewise")->required();
  command->add_option("--timestamps", arguments->timestamps,
                      fmt::format("Times of a KITTI file, {}; only if the other file has timestamps [times.txt "
                                  "beside the KITTI file]",
                                  kTimesPerLine));
  command->add_option("--time-tolerance", arguments->time_tolerance,
                      "Largest time difference of associated poses, seconds [half the ground truth's interval, at most "
                      "0.02]");
  command->add_option(
      "--keyframes", arguments->keyframes,
      "trajectory.csv of the run: the relative error of distance (scale error ratio) is computed between its "
      "keyframes [the one beside ESTIMATE, else over steps of 1 m]");
  command->add_option(
      "--camera-rotation", arguments->camera_rotation,
      "Camera-to-vehicle rotation, yaw,pitch,roll in degrees or a YAML file, to compute the turning angles of the car "
      "[0,0,0]");
  command->add_option("--json", arguments->json,
                      "Write the results to this JSON file; -: to standard output, instead of the table");
  command->add_option("--report", arguments->report, "Write a page (HTML) that shows both trajectories");
  command->add_option("--picture", arguments->picture, "Draw a top view of both trajectories to this SVG file");
  command->add_option("--floor-plan", arguments->floor_plan,
                      "floor_plan.csv of a simulated drive, drawn under the trajectories");
  command->footer("Example:\n  turnscale evaluate out/drive/trajectory.tum poses.txt --picture path.svg");
  command->callback([arguments] { RunEvaluate(*arguments); });
}

}  // namespace turnscale
