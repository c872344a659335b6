// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/commands/evaluation_report.h"
#include "turnscale/evaluation/evaluation.h"

namespace turnscale {

/// What is compared, as the options of `evaluate` name it.
struct ComparisonFiles {
  std::filesystem::path estimate;
  std::filesystem::path ground_truth;
  std::filesystem::path timestamps;  ///< may be empty, as the following
  std::filesystem::path keyframes;
  std::optional<double> time_tolerance = {};
  std::optional<std::string> camera_rotation = {};
};

/// An estimated trajectory with the true one, pose by pose.
struct Comparison {
  PosePairs pairs;
  bool timed = true;   ///< else the pairs carry the numbers of their poses as times
  bool metric = true;  ///< else the estimate is of a run that is up to scale
  Evaluation evaluation;
  EvaluationSources sources;
};

/// All files that a comparison reads, also those that it finds by itself; summaries of runs are not among them.
std::vector<std::filesystem::path> FilesRead(const ComparisonFiles& arguments);

/// Reads both trajectories, pairs their poses and computes the errors. Throws InputError that names file and line, or
/// says why they do not fit.
Comparison Compare(const ComparisonFiles& arguments);

/// What `evaluate --json` writes.
std::string ComparisonJson(const Comparison& comparison);

}  // namespace turnscale
