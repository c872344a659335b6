// SPDX-License-Identifier: MIT
#include "turnscale/commands/evaluate_command.h"

#include <string>
#include <vector>

#include "turnscale/commands/argument_checks.h"
#include "turnscale/commands/run_of_trajectory.h"
#include "turnscale/commands/version.h"
#include "turnscale/evaluation/path_picture.h"
#include "turnscale/geometry/level_frame.h"
#include "turnscale/io/floor_plan_file.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/report/report_data.h"
#include "turnscale/report/report_page.h"
#include "turnscale/report/run_report.h"
#include "turnscale/run/settings.h"

namespace turnscale {
namespace {

// Right and ahead on the page. Outlines of a scene lie in the plane of x and z.
Eigen::Matrix<double, 2, 3> PageAxes(const EvaluateArguments& arguments, const Comparison& comparison) {
  if (!arguments.floor_plan.empty()) {
    Eigen::Matrix<double, 2, 3> axes = Eigen::Matrix<double, 2, 3>::Zero();
    axes(0, 0) = axes(1, 2) = 1;
    return axes;
  }
  Trajectory truth;
  for (const PosePair& pair : comparison.pairs) truth.push_back({pair.time, pair.truth});
  return TopViewAxes(truth, arguments.camera_rotation ? ReadCameraRotation(*arguments.camera_rotation)
                                                      : Eigen::Quaterniond::Identity());
}

// The estimate as given, its first pose aligned with ground truth.
void DrawPath(const EvaluateArguments& arguments, const Comparison& comparison) {
  PathPicture picture;
  picture.title = arguments.estimate.string();
  if (!arguments.floor_plan.empty()) picture.outlines = ReadFloorPlan(arguments.floor_plan);
  const Eigen::Matrix<double, 2, 3> axes = PageAxes(arguments, comparison);
  const auto from_above = [&](const Eigen::Vector3d& place) { return Eigen::Vector2d(axes * place); };
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
  data.version = Version();
  data.metric = comparison.metric;
  data.timed = comparison.timed;
  data.time_origin = FirstTimeOfRun(arguments.estimate);
  data.has_tracking = false;
  data.has_scale_state = false;
  if (arguments.camera_rotation) data.vehicle_from_body = ReadCameraRotation(*arguments.camera_rotation);
  data.warnings = comparison.sources.warnings;
  data.notes = {"Compared with " + ShortPath(arguments.ground_truth.string())};
  for (const PosePair& pair : comparison.pairs) {
    FrameResult frame;
    frame.frame = pair.estimate_index;
    frame.time = pair.time;
    frame.world_from_camera = pair.estimate;
    data.frames.push_back(frame);
  }
  data.truth = comparison.pairs;
  data.errors = ErrorFacts(ComparisonJson(comparison), data.metric);
  if (!arguments.floor_plan.empty()) data.outlines = ReadFloorPlan(arguments.floor_plan);
  ReplaceFile(arguments.report, ReportPage(arguments.estimate.filename().string(), ReportJson(data)));
}

}  // namespace

Comparison ExecuteEvaluate(const EvaluateArguments& given, const CommandHooks& hooks) {
  EvaluateArguments arguments = given;
  arguments.estimate = TrajectoryOf(given.estimate);
  arguments.ground_truth = TrajectoryOf(given.ground_truth);
  RequireFor({"--floor-plan", !arguments.floor_plan.empty()}, !arguments.picture.empty() || !arguments.report.empty(),
             "--picture or --report");
  std::vector<std::filesystem::path> read = FilesRead(arguments);
  read.push_back(arguments.floor_plan);
  const std::vector<NamedOutput> outputs = {{"--json", arguments.json == "-" ? "" : arguments.json},
                                            {"--picture", arguments.picture},
                                            {"--report", arguments.report}};
  CheckOutputs(outputs, read);
  RefuseResultsOfRun(outputs);
  const Comparison comparison = Compare(arguments);
  for (const std::string& warning : comparison.sources.warnings) Warn(hooks, warning);
  if (!arguments.picture.empty()) DrawPath(arguments, comparison);
  if (!arguments.report.empty()) WriteReport(arguments, comparison);
  if (!arguments.json.empty() && arguments.json != "-") ReplaceFile(arguments.json, ComparisonJson(comparison));
  return comparison;
}

}  // namespace turnscale
