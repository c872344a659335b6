// SPDX-License-Identifier: MIT
#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "argument_checks.h"
#include "commands.h"
#include "comparison.h"
#include "evaluation_report.h"
#include "turnscale/evaluation/path_picture.h"
#include "turnscale/io/floor_plan_file.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/settings.h"
#include "turnscale/io/terminal.h"
#include "turnscale/report/report_data.h"
#include "turnscale/report/report_page.h"
#include "turnscale/report/run_report.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct EvaluateArguments : ComparisonFiles {
  std::string json;
  fs::path picture;
  fs::path report;
  fs::path floor_plan;
};

// The estimate as given, its first pose aligned with ground truth.
void DrawPath(const EvaluateArguments& arguments, const Comparison& comparison) {
  PathPicture picture;
  picture.title = arguments.estimate.string();
  if (!arguments.floor_plan.empty()) picture.outlines = ReadFloorPlan(arguments.floor_plan);
  const auto from_above = [](const Eigen::Vector3d& place) { return Eigen::Vector2d(place.x(), place.z()); };
  const Similarity& truth_from_estimate = comparison.evaluation.from_first_pose.truth_from_estimate;
  for (const PosePair& pair : comparison.pairs) {
    picture.truth.push_back(from_above(pair.truth.translation));
    picture.estimate.push_back(from_above(truth_from_estimate * pair.estimate.translation));
  }
  ReplaceFile(arguments.picture, PathSvg(picture));
}

void WriteReport(const EvaluateArguments& arguments, const Comparison& comparison) {
  ReportData data;
  data.title = arguments.estimate.string();
  data.version = TURNSCALE_VERSION;
  data.metric = true;
  data.timed = comparison.timed;
  data.has_tracking = false;
  data.has_scale_state = false;
  if (arguments.camera_rotation) data.vehicle_from_body = ReadCameraRotation(*arguments.camera_rotation);
  data.notes = {"Compared with " + arguments.ground_truth.string()};
  for (const PosePair& pair : comparison.pairs) {
    FrameResult frame;
    frame.frame = pair.estimate_index;
    frame.time = pair.time;
    frame.world_from_camera = pair.estimate;
    data.frames.push_back(frame);
  }
  data.truth = comparison.pairs;
  data.errors = ErrorFacts(ComparisonJson(comparison));
  if (!arguments.floor_plan.empty()) data.outlines = ReadFloorPlan(arguments.floor_plan);
  ReplaceFile(arguments.report, ReportPage(arguments.estimate.filename().string(), ReportJson(data)));
}

void RunEvaluate(const EvaluateArguments& arguments) {
  const auto read = {arguments.estimate, arguments.ground_truth, arguments.timestamps, arguments.keyframes,
                     arguments.floor_plan};
  RefuseToOverwrite("--json", arguments.json, read);
  RefuseToOverwrite("--picture", arguments.picture, read);
  RefuseToOverwrite("--report", arguments.report, read);
  const Comparison comparison = Compare(arguments);
  if (!arguments.picture.empty()) DrawPath(arguments, comparison);
  if (!arguments.report.empty()) WriteReport(arguments, comparison);
  const std::string json = ComparisonJson(comparison);
  if (arguments.json == "-") {
    WriteStandardOutput(json);
    return;
  }
  if (!arguments.json.empty()) ReplaceFile(arguments.json, json);
  PrintText(EvaluationTable(comparison.evaluation, comparison.sources));
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  auto* command = app.add_subcommand("evaluate", "Evaluate a trajectory against ground truth.");
  const auto arguments = std::make_shared<EvaluateArguments>();
  command->add_option("ESTIMATE", arguments->estimate, "Estimated trajectory: TUM, EuRoC or KITTI file")->required();
  command->add_option("GROUND_TRUTH", arguments->ground_truth, "Ground-truth trajectory: TUM, EuRoC or KITTI file")
      ->required();
  command->add_option(
      "--timestamps", arguments->timestamps,
      "Times of the KITTI file in seconds, one per line, if the other file has timestamps [times.txt beside it]");
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
  CLI::Option* report =
      command->add_option("--report", arguments->report, "Write a page (HTML) that shows both trajectories");
  CLI::Option* picture =
      command->add_option("--picture", arguments->picture, "Draw a top view of both trajectories to this SVG file");
  CLI::Option* plan = command->add_option("--floor-plan", arguments->floor_plan,
                                          "floor_plan.csv of a simulated drive, drawn under the trajectories");
  plan->check([picture, report](const std::string&) {
    return picture->count() + report->count() > 0 ? "" : "needs --picture or --report";
  });
  command->footer("Example:\n  turnscale evaluate out/drive/trajectory.tum poses.txt --picture path.svg");
  command->callback([arguments] { RunEvaluate(*arguments); });
}

}  // namespace turnscale
