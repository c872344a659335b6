// SPDX-License-Identifier: MIT
#include "turnscale/scale/turn_selection.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "turnscale/base/quantiles.h"
#include "turnscale/scale/scale_filter.h"

namespace turnscale {

MeanTurnDirection MeanDirectionOfTurns(const std::vector<SegmentEvidence>& gathered, const EvidenceOptions& options) {
  double information = 0;
  double sum = 0;
  for (const SegmentEvidence& segment : gathered) {
    if (!segment.direction_in_turn) continue;
    const DirectionInTurn& direction = *segment.direction_in_turn;
    information += 1 / (direction.sigma * direction.sigma);
    sum += direction.angle / (direction.sigma * direction.sigma);
  }
  if (!(information > 0)) return {};
  return {sum / information, 1 / information + options.direction_in_turn_sigma * options.direction_in_turn_sigma};
}

DriveState StartingState(const CarPrior& car, const MeanTurnDirection& turns) {
  DriveState state = PriorBelief(car, 0).mean;
  const double prior = car.yaw_sigma * car.yaw_sigma;
  if (std::isfinite(turns.variance))
    state[kDirection] += prior / (prior + turns.variance) * (turns.mean - state[kDirection]);
  return state;
}

TurnSelection SelectTurns(const std::vector<SegmentEvidence>& gathered, const CarPrior& car, const DriveState& state,
                          const EvidenceOptions& options) {
  TurnSelection selection{gathered, {}};
  for (SegmentEvidence& segment : selection.evidence) {
    if (!segment.turn) continue;
    segment.why_no_turn =
        car.knows_lever_arm() ? WhyUnusable(*segment.turn, state, options) : std::string("no lever arm given");
    if (segment.why_no_turn.empty())
      selection.log_scales.emplace_back(std::log(OwnScale(*segment.turn, state)), std::abs(segment.turn->angle));
    else
      segment.turn.reset();
  }
  return selection;
}

std::optional<double> StartingLogScale(const TurnSelection& selection, const CarPrior& car) {
  if (!selection.log_scales.empty()) return WeightedMedian(selection.log_scales);
  if (!car.knows_height()) return std::nullopt;
  std::vector<std::pair<double, double>> of_road;
  for (const SegmentEvidence& segment : selection.evidence)
    if (segment.road)
      of_road.emplace_back(std::log(car.camera_height) - segment.road->log_height, segment.road->length);
  return of_road.empty() ? std::nullopt : std::optional(WeightedMedian(of_road));
}

}  // namespace turnscale
