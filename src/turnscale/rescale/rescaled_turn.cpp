// SPDX-License-Identifier: MIT
#include "turnscale/rescale/rescaled_turn.h"

#include <cmath>

namespace turnscale {
namespace {

RescaledTurn Describe(const std::vector<SwayStep>& steps, const Stretch& stretch, const StretchObservation& observation,
                      const Belief& smoothed, const ScaleEstimate& estimate, double common_sigma) {
  const DriveState& state = smoothed.mean;
  const double lever_arm = estimate.problem.lever_arm;
  RescaledTurn turn;
  turn.first_pose = steps[stretch.first].first;
  turn.last_pose = steps[stretch.last].last;
  turn.angle = stretch.angle;
  turn.smoothed = std::exp(state[kLogScale]);
  turn.smoothed_sigma = std::hypot(std::sqrt(smoothed.covariance(kLogScale, kLogScale)), common_sigma);
  turn.metres_per_unit = ScaleOfStretch(observation.pooled, state, lever_arm).value_or(0);
  turn.used = observation.turning;
  if (turn.used) {
    const ScaleEvidence evidence = EvidenceAt(observation, state, lever_arm, estimate.noise.stretch);
    turn.sigma = 1 / std::sqrt(evidence.information(kLogScale, kLogScale));
  }
  const Eigen::Matrix4d& pooled = observation.pooled.information;
  const Eigen::Vector4d coefficients = SwayCoefficients(state, lever_arm);
  const double lever_part =
      observation.pooled.target[0] - pooled(0, 2) * coefficients[2] - pooled(0, 3) * coefficients[3];
  turn.effective_lever_arm = turn.smoothed * lever_part / pooled(0, 0);
  turn.speed = turn.smoothed * std::sqrt(MeanSquareSpeed(observation.pooled));
  turn.weight = observation.lever_weight;
  return turn;
}

}  // namespace

std::vector<RescaledTurn> DescribeTurns(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                        const ScaleEstimate& estimate, double common_sigma) {
  std::vector<RescaledTurn> turns;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    if (!stretches[i].turning) continue;
    turns.push_back(
        Describe(steps, stretches[i], estimate.problem.observations[i], estimate.smoothed[i], estimate, common_sigma));
  }
  return turns;
}

}  // namespace turnscale
