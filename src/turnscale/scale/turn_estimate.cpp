// SPDX-License-Identifier: MIT
#include "turnscale/scale/turn_estimate.h"

#include <cmath>

namespace turnscale {
namespace {

TurnEstimate DescribeTurn(const ScaleProblem& problem, int place, const DriveState& as_given) {
  const PathSegment& segment = problem.segments[place];
  const SegmentEvidence& evidence = problem.evidence[place];
  TurnEstimate turn;
  turn.segment = place;
  turn.first_step = segment.first;
  turn.last_step = segment.last;
  turn.angle = segment.angle;
  turn.used = evidence.turn.has_value();
  turn.reason = evidence.why_no_turn;
  if (!turn.used) return turn;
  turn.lever_arm_units = evidence.turn->lever_arm;
  turn.speed_units = std::sqrt(std::abs(evidence.turn->mean_square_speed));
  turn.as_given = OwnScale(*evidence.turn, as_given);
  if (!std::isfinite(turn.as_given)) return turn;
  DriveState at = as_given;
  at[kLogScale] = std::log(turn.as_given);
  const Measurement measurement = LinearizeTurn(*evidence.turn, at, problem.options);
  turn.as_given_relative_sigma = std::sqrt(measurement.variance) / std::abs(measurement.by_state[kLogScale]);
  turn.own = turn.as_given;
  turn.own_relative_sigma = turn.as_given_relative_sigma;
  return turn;
}

}  // namespace

std::vector<TurnEstimate> DescribeTurns(const ScaleProblem& problem, const DriveState& as_given) {
  std::vector<TurnEstimate> turns;
  for (int i = 0; i < static_cast<int>(problem.segments.size()); ++i)
    if (problem.segments[i].turning) turns.push_back(DescribeTurn(problem, i, as_given));
  return turns;
}

void LeaveOutTurns(const std::string& reason, std::vector<TurnEstimate>& turns) {
  for (TurnEstimate& turn : turns) {
    if (!turn.used) continue;
    turn.used = false;
    turn.reason = reason;
  }
}

}  // namespace turnscale
