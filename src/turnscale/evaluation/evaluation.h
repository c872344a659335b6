// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/evaluation/association.h"
#include "turnscale/evaluation/position_error.h"
#include "turnscale/evaluation/segment_error.h"
#include "turnscale/evaluation/step_error.h"

namespace turnscale {

struct EvaluationOptions {
  SegmentOptions segments;
  StepErrorOptions steps;
};

/// The errors that depend on the scale, at one scale of the estimate.
struct ScaledErrors {
  double scale = 1;              ///< by which the estimate's translations were multiplied
  double path_length_error = 0;  ///< (estimated - true) / true
  SegmentErrors segments;
  StepErrors all_steps;
  StepErrors turning_steps;
};

/// Errors of an estimated trajectory against ground truth.
struct Evaluation {
  int poses = 0;                ///< paired
  double true_path_length = 0;  ///< metres
  ScaledErrors as_given;
  PositionErrors from_first_pose;
  /// The rest is empty where the positions determine no alignment; `alignment_problem` then says why.
  std::optional<PositionErrors> rigid;
  std::optional<PositionErrors> similarity;
  std::optional<ScaledErrors> rescaled;  ///< at the scale of the similarity
  std::string alignment_problem;
};

/// Computes all errors. Throws InputError when the path length of the ground truth is too short.
Evaluation Evaluate(const PosePairs& pairs, const std::vector<Step>& steps, const EvaluationOptions& options = {});

}  // namespace turnscale
