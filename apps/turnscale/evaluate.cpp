// SPDX-License-Identifier: MIT
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "argument_checks.h"
#include "commands.h"
#include "evaluation_report.h"
#include "turnscale/base/error.h"
#include "turnscale/evaluation/evaluation.h"
#include "turnscale/evaluation/path_picture.h"
#include "turnscale/io/drive_input.h"
#include "turnscale/io/floor_plan_file.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/settings.h"
#include "turnscale/io/terminal.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct EvaluateArguments {
  fs::path estimate;
  fs::path ground_truth;
  fs::path timestamps;
  fs::path keyframes;
  std::string json;
  fs::path picture;
  fs::path floor_plan;
  std::optional<double> time_tolerance;
  std::optional<std::string> camera_rotation;
};

struct Paired {
  PosePairs pairs;
  KeyframeKey key = KeyframeKey::kTime;
  const char* by = "time";
};

bool HasTimes(const TrajectoryFile& file) { return file.format != TrajectoryFormat::kKitti; }

bool NumbersEveryFrame(const TrajectoryFile& file) {
  return file.frames.back() + 1 == static_cast<int>(file.frames.size());
}

Paired PairFrames(const TrajectoryFile& estimate, const TrajectoryFile& truth) {
  if (NumbersEveryFrame(estimate) && NumbersEveryFrame(truth)) {
    return {AssociateByFrame(estimate.poses, truth.poses), KeyframeKey::kFrame, "frame"};
  }
  // Without times, the time of a KITTI pose is its frame's number.
  return {AssociateByTime(estimate.poses, truth.poses, {0.5}), KeyframeKey::kFrame, "frame"};
}

Paired PairPoses(const EvaluateArguments& arguments, TrajectoryFile& estimate, TrajectoryFile& truth) {
  const bool estimate_has_times = HasTimes(estimate);
  const bool truth_has_times = HasTimes(truth);
  if (estimate_has_times == truth_has_times && !arguments.timestamps.empty()) {
    throw InputError(
        "--timestamps " + arguments.timestamps.string() + ": is not needed, since " +
        (truth_has_times ? "both files have timestamps" : "two KITTI files are associated by frame number") +
        "; leave it out");
  }
  if (!estimate_has_times && !truth_has_times) return PairFrames(estimate, truth);
  if (estimate_has_times != truth_has_times) {
    const fs::path& untimed_path = estimate_has_times ? arguments.ground_truth : arguments.estimate;
    TrajectoryFile& untimed = estimate_has_times ? truth : estimate;
    const fs::path times = arguments.timestamps.empty() ? FindPoseTimes(untimed_path) : arguments.timestamps;
    if (times.empty()) {
      if (estimate.poses.size() == truth.poses.size()) {
        const KeyframeKey key = estimate_has_times ? KeyframeKey::kTime : KeyframeKey::kFrame;
        return {AssociateByFrame(estimate.poses, truth.poses), key, "frame"};
      }
      throw InputError(untimed_path.string() + " has no timestamps, and " + std::to_string(estimate.poses.size()) +
                       " estimated poses cannot be associated with " + std::to_string(truth.poses.size()) +
                       " ground-truth poses; give its times with --timestamps");
    }
    untimed = ReadTrajectoryFile(untimed_path, ReadFrameTimes(times).times);
  }
  return {AssociateByTime(estimate.poses, truth.poses, {arguments.time_tolerance}), KeyframeKey::kTime, "time"};
}

std::vector<Step> ReadKeyframeSteps(const fs::path& path, const Paired& paired) {
  std::ifstream stream(path);
  if (!stream || fs::is_directory(path)) throw InputError(path.string() + ": cannot be read");
  auto steps = StepsBetweenKeyframes(paired.pairs, ReadKeyframes(stream, path.string()), paired.key);
  if (steps.empty()) {
    throw InputError(path.string() + ": fewer than two of its keyframes have a pose in both trajectories");
  }
  return steps;
}

std::vector<Step> FindSteps(const EvaluateArguments& arguments, const Paired& paired, const StepErrorOptions& options,
                            std::string& description) {
  const bool asked = !arguments.keyframes.empty();
  const fs::path path = asked ? arguments.keyframes : arguments.estimate.parent_path() / "trajectory.csv";
  if (asked || fs::exists(path)) {
    try {
      auto steps = ReadKeyframeSteps(path, paired);
      description = "between the keyframes of " + path.string();
      return steps;
    } catch (const InputError&) {
      // A table that merely lies in the same folder may belong to something else.
      if (asked) throw;
    }
  }
  description = "of 1 m of ground-truth path length";
  return StepsAlongPath(paired.pairs, options);
}

// The estimate as given, its first pose aligned with ground truth.
void DrawPath(const EvaluateArguments& arguments, const Paired& paired, const Evaluation& evaluation) {
  PathPicture picture;
  picture.title = arguments.estimate.string();
  if (!arguments.floor_plan.empty()) picture.outlines = ReadFloorPlan(arguments.floor_plan);
  const auto from_above = [](const Eigen::Vector3d& place) { return Eigen::Vector2d(place.x(), place.z()); };
  for (const PosePair& pair : paired.pairs) {
    picture.truth.push_back(from_above(pair.truth.translation));
    picture.estimate.push_back(from_above(evaluation.from_first_pose.truth_from_estimate * pair.estimate.translation));
  }
  ReplaceFile(arguments.picture, PathSvg(picture));
}

void RunEvaluate(const EvaluateArguments& arguments) {
  if (arguments.time_tolerance && !(*arguments.time_tolerance >= 0)) {
    throw InputError(fmt::format("--time-tolerance {}: give seconds, 0 or more", *arguments.time_tolerance));
  }
  const auto read = {arguments.estimate, arguments.ground_truth, arguments.timestamps, arguments.keyframes,
                     arguments.floor_plan};
  RefuseToOverwrite("--json", arguments.json, read);
  RefuseToOverwrite("--picture", arguments.picture, read);
  EvaluationOptions options;
  if (arguments.camera_rotation) options.steps.vehicle_from_camera = ReadCameraRotation(*arguments.camera_rotation);
  TrajectoryFile estimate = ReadTrajectoryFile(arguments.estimate);
  TrajectoryFile truth = ReadTrajectoryFile(arguments.ground_truth);
  const Paired paired = PairPoses(arguments, estimate, truth);
  EvaluationSources sources;
  sources.estimate = arguments.estimate.string();
  sources.ground_truth = arguments.ground_truth.string();
  sources.estimated_poses = static_cast<int>(estimate.poses.size());
  sources.true_poses = static_cast<int>(truth.poses.size());
  sources.pairing = paired.by;
  const std::vector<Step> steps = FindSteps(arguments, paired, options.steps, sources.steps);
  const Evaluation evaluation = Evaluate(paired.pairs, steps, options);
  if (!arguments.picture.empty()) DrawPath(arguments, paired, evaluation);
  // Names of files may be no UTF-8.
  const auto replace = nlohmann::ordered_json::error_handler_t::replace;
  const std::string json = EvaluationJson(evaluation, sources).dump(2, ' ', false, replace) + "\n";
  if (arguments.json == "-") {
    WriteStandardOutput(json);
    return;
  }
  if (!arguments.json.empty()) ReplaceFile(arguments.json, json);
  PrintText(EvaluationTable(evaluation, sources));
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
  CLI::Option* picture =
      command->add_option("--picture", arguments->picture, "Draw a top view of both trajectories to this SVG file");
  command
      ->add_option("--floor-plan", arguments->floor_plan,
                   "floor_plan.csv of a simulated drive, drawn under the trajectories")
      ->needs(picture);
  command->footer("Example:\n  turnscale evaluate out/drive/trajectory.tum poses.txt --picture path.svg");
  command->callback([arguments] { RunEvaluate(*arguments); });
}

}  // namespace turnscale
