// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/position_error.h"

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

PositionErrors Measure(const PosePairs& pairs, const Similarity& truth_from_estimate) {
  std::vector<double> distances;
  for (const PosePair& pair : pairs) {
    distances.push_back((truth_from_estimate * pair.estimate.translation - pair.truth.translation).norm());
  }
  return {truth_from_estimate, Summarize(std::move(distances))};
}

}  // namespace

PositionErrors MeasurePositionsFromFirstPose(const PosePairs& pairs) {
  if (pairs.empty()) throw InputError("no paired poses to compare");
  const RigidTransform truth_from_estimate = pairs.front().truth * pairs.front().estimate.inverse();
  return Measure(pairs, {1.0, truth_from_estimate.rotation, truth_from_estimate.translation});
}

PositionErrors MeasureAlignedPositions(const PosePairs& pairs, AlignmentModel model) {
  std::vector<Eigen::Vector3d> estimate;
  std::vector<Eigen::Vector3d> truth;
  for (const PosePair& pair : pairs) {
    estimate.push_back(pair.estimate.translation);
    truth.push_back(pair.truth.translation);
  }
  return Measure(pairs, AlignPoints(estimate, truth, model));
}

}  // namespace turnscale
