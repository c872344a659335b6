// SPDX-License-Identifier: MIT
#include "turnscale/commands/comparison.h"

#include <algorithm>
#include <fstream>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/input_file.h"
#include "turnscale/commands/axes_of_poses.h"
#include "turnscale/commands/run_of_trajectory.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/settings.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

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

void RefuseTolerance(const ComparisonFiles& arguments, const std::string& why) {
  if (arguments.time_tolerance) throw InputError("--time-tolerance: is not needed, since " + why + "; leave it out");
}

void RefuseTimestamps(const ComparisonFiles& arguments, const std::string& why) {
  if (!arguments.timestamps.empty())
    throw InputError("--timestamps " + arguments.timestamps.string() + ": is not needed, since " + why +
                     "; leave it out");
}

Paired PairPoses(const ComparisonFiles& arguments, TrajectoryFile& estimate, TrajectoryFile& truth) {
  const bool estimate_has_times = HasTimes(estimate);
  const bool truth_has_times = HasTimes(truth);
  if (!estimate_has_times && !truth_has_times) {
    const std::string why = "two KITTI files are associated by frame number";
    RefuseTimestamps(arguments, why);
    RefuseTolerance(arguments, why);
    return PairFrames(estimate, truth);
  }
  if (estimate_has_times && truth_has_times) RefuseTimestamps(arguments, "both files have timestamps");
  if (estimate_has_times != truth_has_times) {
    const fs::path& untimed_path = estimate_has_times ? arguments.ground_truth : arguments.estimate;
    TrajectoryFile& untimed = estimate_has_times ? truth : estimate;
    const fs::path times = arguments.timestamps.empty() ? FindPoseTimes(untimed_path) : arguments.timestamps;
    if (times.empty()) {
      if (estimate.poses.size() == truth.poses.size()) {
        RefuseTolerance(arguments, "poses without times are associated one by one");
        const KeyframeKey key = estimate_has_times ? KeyframeKey::kTime : KeyframeKey::kFrame;
        return {AssociateByFrame(estimate.poses, truth.poses), key, "frame"};
      }
      throw InputError(untimed_path.string() + " has no timestamps, and " + std::to_string(estimate.poses.size()) +
                       " estimated poses cannot be associated with " + std::to_string(truth.poses.size()) +
                       " ground-truth poses; put a times.txt beside it, or give turnscale evaluate its times with "
                       "--timestamps");
    }
    untimed = ReadTrajectoryFile(untimed_path, ReadFrameTimes(times).times);
  }
  return {AssociateByTime(estimate.poses, truth.poses, {arguments.time_tolerance}), KeyframeKey::kTime, "time"};
}

constexpr auto kOnlyScaledErrors = "only errors of the scaled trajectory and after Sim(3) alignment are meaningful";

// What is up to scale of the online trajectory of a run whose refined one is in metres. Empty if nothing is.
std::string LiveWarning(const fs::path& file, const Trajectory& poses) {
  const nlohmann::json scale = ScaleOfRun(file);
  if (!scale.contains("live_metres_from_s")) return "poses from before the scale was known, if any, are up to scale";
  const nlohmann::json& from = scale["live_metres_from_s"];
  if (!from.is_number())
    return fmt::format("is up to scale, as the scale was not known before the end of the drive: {}", kOnlyScaledErrors);
  const auto seconds = from.get<double>();
  if (poses.empty() || poses.front().time >= seconds) return {};
  return fmt::format("poses before {:.1f} s are up to scale; then the scale became known, and the position jumps",
                     seconds - FirstTimeOfRun(file).value_or(0.0));
}

// The same poses as the estimate's, without times, as a run writes both; empty if there are none.
fs::path UntimedTwin(const fs::path& estimate) {
  const fs::path twin = estimate.parent_path() / RunFiles::kTrajectoryKitti;
  std::error_code none;
  return estimate.filename() == RunFiles::kTrajectoryTum && fs::exists(twin, none) ? twin : fs::path();
}

// Where both files have poses all along but few of them pair, their times are of different clocks.
std::string UnpairedWarning(const fs::path& file, const Paired& paired, const Trajectory& estimate,
                            const Trajectory& truth) {
  constexpr double kLeastPaired = 0.8;
  if (std::string_view(paired.by) != "time") return {};
  const int paired_poses = static_cast<int>(paired.pairs.size());
  const fs::path twin = estimate.size() == truth.size() ? UntimedTwin(file) : fs::path();
  if (!twin.empty() && paired_poses < kLeastPaired * static_cast<double>(estimate.size()))
    return fmt::format(
        "only {} poses are paired by time, though both files have {}: the errors may be wrong; check that both are of "
        "the same drive, and give turnscale evaluate {} instead, which is paired by frame number",
        paired_poses, estimate.size(), twin.string());
  const CommonPoses common = PosesInCommonTime(estimate, truth);
  if (paired_poses >= kLeastPaired * std::min(common.estimated, common.in_truth)) return {};
  return fmt::format(
      "only {} poses are paired, though the files have {} (estimate) and {} (ground truth) in the time that both "
      "cover: the errors may be wrong; check that both are of the same drive, with the times of one clock "
      "(--timestamps are those of the ground truth), before a larger --time-tolerance",
      paired_poses, common.estimated, common.in_truth);
}

std::vector<std::string> Warnings(const ComparisonFiles& files, const Paired& paired, const Trajectory& estimate,
                                  const Trajectory& truth) {
  const std::string estimated = files.estimate.string() + ": ";
  std::vector<std::string> warnings;
  if (const std::string unpaired = UnpairedWarning(files.estimate, paired, estimate, truth); !unpaired.empty())
    warnings.push_back(estimated + unpaired);
  const std::string state = ScaleStateOfRun(files.estimate);
  if (IsOfRearAxle(files.estimate))
    warnings.push_back(estimated +
                       "has the poses of the rear axle (--frame vehicle): if the ground truth is the camera's, the "
                       "errors include its distance from the axle");
  if (state == kPendingScale) {
    warnings.push_back(estimated + fmt::format("is up to scale (pending): {}", kOnlyScaledErrors));
  } else if (!state.empty() && files.estimate.filename() == RunFiles::kLiveTum) {
    if (const std::string live = LiveWarning(files.estimate, estimate); !live.empty())
      warnings.push_back(estimated + live);
  }
  if (!ScaleStateOfRun(files.ground_truth).empty())
    warnings.push_back(files.ground_truth.string() +
                       ": is the result of a run, not ground truth; give the estimate first, the ground truth second");
  return warnings;
}

std::vector<Step> ReadKeyframeSteps(const fs::path& path, const Paired& paired) {
  std::ifstream stream = OpenInputFile(path, "table of keyframes");
  auto steps = StepsBetweenKeyframes(paired.pairs, ReadKeyframes(stream, path.string()), paired.key);
  if (steps.empty()) {
    throw InputError(path.string() + ": fewer than two of its keyframes have a pose in both trajectories");
  }
  return steps;
}

std::vector<Step> FindSteps(const ComparisonFiles& arguments, const Paired& paired, const StepErrorOptions& options,
                            std::string& description) {
  const bool asked = !arguments.keyframes.empty();
  const fs::path path = asked ? arguments.keyframes : arguments.estimate.parent_path() / RunFiles::kTrajectoryTable;
  std::error_code none;
  if (asked || fs::exists(path, none)) {
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

}  // namespace

std::vector<fs::path> FilesRead(const ComparisonFiles& arguments) {
  std::vector<fs::path> files = {arguments.estimate, arguments.ground_truth, arguments.keyframes,
                                 arguments.camera_rotation.value_or("")};
  if (arguments.keyframes.empty()) files.push_back(arguments.estimate.parent_path() / RunFiles::kTrajectoryTable);
  if (!arguments.timestamps.empty()) {
    files.push_back(arguments.timestamps);
  } else {
    for (const fs::path& poses : {arguments.estimate, arguments.ground_truth}) files.push_back(FindPoseTimes(poses));
  }
  return files;
}

Comparison Compare(const ComparisonFiles& arguments) {
  if (arguments.time_tolerance && !(*arguments.time_tolerance >= 0)) {
    throw InputError(fmt::format("--time-tolerance {}: give seconds, 0 or more", *arguments.time_tolerance));
  }
  EvaluationOptions options;
  if (arguments.camera_rotation) options.steps.vehicle_from_camera = ReadCameraRotation(*arguments.camera_rotation);
  TrajectoryFile estimate = ReadTrajectoryFile(arguments.estimate);
  TrajectoryFile truth = ReadTrajectoryFile(arguments.ground_truth);
  Paired paired = PairPoses(arguments, estimate, truth);
  Comparison comparison;
  comparison.sources.estimate = arguments.estimate.string();
  comparison.sources.ground_truth = arguments.ground_truth.string();
  comparison.sources.estimated_poses = static_cast<int>(estimate.poses.size());
  comparison.sources.true_poses = static_cast<int>(truth.poses.size());
  comparison.sources.pairing = paired.by;
  comparison.sources.run_length = PathLengthOfRun(arguments.estimate);
  comparison.sources.warnings = Warnings(arguments, paired, estimate.poses, truth.poses);
  // A run's own page shows its poses as they are.
  const bool keeps_axes = arguments.camera_rotation || !ScaleStateOfRun(arguments.estimate).empty();
  const std::string other_axes =
      UniteAxes({arguments.estimate.string(), arguments.ground_truth.string(), keeps_axes}, paired.pairs);
  if (!other_axes.empty()) comparison.sources.warnings.push_back(other_axes);
  const std::vector<Step> steps = FindSteps(arguments, paired, options.steps, comparison.sources.steps);
  comparison.evaluation = Evaluate(paired.pairs, steps, options);
  comparison.pairs = paired.pairs;
  comparison.metric = ScaleStateOfRun(arguments.estimate) != kPendingScale;
  comparison.timed = paired.key == KeyframeKey::kTime;
  return comparison;
}

std::string ComparisonJson(const Comparison& comparison) {
  // Names of files may not be valid UTF-8.
  const auto replace = nlohmann::ordered_json::error_handler_t::replace;
  return EvaluationJson(comparison.evaluation, comparison.sources).dump(2, ' ', false, replace) + "\n";
}

}  // namespace turnscale
