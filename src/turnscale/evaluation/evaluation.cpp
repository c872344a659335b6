// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/evaluation.h"

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

ScaledErrors MeasureAtScale(const PosePairs& pairs, const std::vector<Step>& steps, double scale,
                            const EvaluationOptions& options) {
  ScaledErrors errors;
  errors.scale = scale;
  errors.segments = MeasureSegments(pairs, scale, options.segments);
  errors.path_length_error = scale * EstimatedPathLength(pairs) / TruePathLength(pairs) - 1;
  errors.all_steps = MeasureSteps(pairs, steps, false, scale, options.steps);
  errors.turning_steps = MeasureSteps(pairs, steps, true, scale, options.steps);
  return errors;
}

}  // namespace

Evaluation Evaluate(const PosePairs& pairs, const std::vector<Step>& steps, const EvaluationOptions& options) {
  Evaluation evaluation;
  evaluation.poses = static_cast<int>(pairs.size());
  evaluation.true_path_length = TruePathLength(pairs);
  evaluation.from_first_pose = MeasurePositionsFromFirstPose(pairs);
  evaluation.as_given = MeasureAtScale(pairs, steps, 1.0, options);
  try {
    evaluation.rigid = MeasureAlignedPositions(pairs, AlignmentModel::kRigid);
    evaluation.similarity = MeasureAlignedPositions(pairs, AlignmentModel::kSimilarity);
    evaluation.rescaled = MeasureAtScale(pairs, steps, evaluation.similarity->truth_from_estimate.scale, options);
  } catch (const InputError& error) {
    // A dead straight drive still has a length and a scale to judge.
    evaluation.alignment_problem = error.what();
  }
  return evaluation;
}

}  // namespace turnscale
