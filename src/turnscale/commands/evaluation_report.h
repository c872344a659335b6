// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "turnscale/evaluation/evaluation.h"

namespace turnscale {

/// What the reader of an evaluation wants to know about its input.
struct EvaluationSources {
  std::string estimate;              ///< file
  std::string ground_truth;          ///< file
  std::optional<double> run_length;  ///< of the whole path, as the run states it, in its unit; empty without a run
  int estimated_poses = 0;
  int true_poses = 0;
  std::string pairing;                ///< "time" or "frame"
  std::string steps;                  ///< what the steps of the scale error ratio are
  std::vector<std::string> warnings;  ///< what makes the numbers doubtful, a line each
};

/// Aligned lines for the screen, in metres, per cent and degrees.
std::string EvaluationTable(const Evaluation& evaluation, const EvaluationSources& sources);

/// The same numbers and the errors of each segment length, with the unit in each name; null where there is none.
nlohmann::ordered_json EvaluationJson(const Evaluation& evaluation, const EvaluationSources& sources);

}  // namespace turnscale
