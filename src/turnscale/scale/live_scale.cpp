// SPDX-License-Identifier: MIT
#include "turnscale/scale/live_scale.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turnscale/base/robust_weights.h"
#include "turnscale/scale/road_parts.h"

namespace turnscale {
namespace {

constexpr int kLocalIterations = 5;
// Metres per second: before the first turn, what the lengths of straights are guessed from.
constexpr double kUsualSpeed = 6;
// Of ln(lambda): above this the scale comes from the priors of scale and height alone.
constexpr double kUnknownScale = 0.5;

// A guess from the usual speed; empty if the steps have no length or no duration.
std::optional<double> UsualMetresPerUnit(std::span<const VehicleStep> steps) {
  double length = 0;
  double duration = 0;
  for (const VehicleStep& step : steps) {
    if (!step.usable) continue;
    length += step.motion.step;
    duration += step.duration;
  }
  return length > 0 && duration > 0 ? std::optional(kUsualSpeed * duration / length) : std::nullopt;
}

// Of a measurement against what is believed before it.
double RobustWeight(const ScaleBelief& belief, const Measurement& measurement, const DriveState& at, double huber) {
  return HuberWeight(std::sqrt(ChiSquared(belief, measurement, 1, at)), huber);
}

// Tyres do not slip inwards: a negative slip-angle coefficient becomes 0, and the other unknowns what they are then.
// The covariance stays.
void HoldSlip(ScaleBelief& belief) {
  if (belief.mean[kSlip] >= 0) return;
  belief.mean -= belief.covariance.col(kSlip) * (belief.mean[kSlip] / belief.covariance(kSlip, kSlip));
  belief.mean[kSlip] = 0;
}

}  // namespace

LiveScale::LiveScale(const CarPrior& car, const ScaleEstimatorOptions& options)
    : car_(car), options_(options), detector_(options.segments.turns), belief_(PriorBelief(car, 0)) {}

TurnEnd LiveScale::Add(const VehicleStep& step) {
  pending_.push_back(step);
  ++steps_;
  const auto closed = step.usable ? detector_.Add(step.motion.psi) : detector_.AddUnmeasured();
  TurnEnd turn_end = TurnEnd::kNone;
  if (closed) {
    EndStraight(closed->first - 1);
    turn_end = EndTurn(closed->last);
  }
  if (step.after_gap || IsUnitBroken(step)) {
    // The unit of length changes. A turn under way stays whole.
    EndStraight(std::min(steps_ - 2, detector_.first_undecided() - 1));
  } else if (!closed &&
             static_cast<int>(pending_.size()) > MostStraightSteps(pending_, options_.segments.max_straight_steps)) {
    // All but a turn that may have begun.
    CutStraight(detector_.first_undecided() - 1);
  }
  UpdateReading();
  return turn_end;
}

void LiveScale::UpdateReading() {
  const std::optional<TurningRegion> open = detector_.open();
  ScaleBelief belief = belief_;
  Advance(pending_, belief);
  // After the end of a segment its state is kept until the next one has some steps.
  const bool begins = static_cast<int>(pending_.size()) < options_.evidence.road.min_steps;
  on_road_ = (TakeRoad(pending_, belief) || (begins && on_road_)) && KnowsHeight(belief);
  bool turning = false;
  if (open) {
    const int begin = open->first - (steps_ - static_cast<int>(pending_.size()));
    TakeDirection(StepsOf(pending_, 0, begin - 1), road_part_, belief);
    TurnUpdate with = WithTurn(belief, StepsOf(pending_, begin, begin + open->last - open->first));
    turning = with.used;
    belief = provisional_ && !turning ? *provisional_ : std::move(with.belief);
  }
  const bool has_source = started_ || turning || provisional_ || on_road_;
  // Once known, the scale stays so.
  const bool is_known = now_ || belief.sigma() <= options_.max_sigma;
  now_.reset();
  if (!has_source || !is_known) return;
  const ScaleState on_straight = on_road_ ? ScaleState::kFromRoad : ScaleState::kHeld;
  now_ = LiveReading{.belief = belief, .state = turning ? ScaleState::kObserved : on_straight};
  if (turning && !started_) provisional_ = belief;
}

void LiveScale::KeepProvisional(std::span<const VehicleStep> turn) {
  const std::optional<ScaleBelief> provisional = std::exchange(provisional_, std::nullopt);
  if (started_ || !provisional) return;
  belief_ = *provisional;
  started_ = true;
  // That of the part which it knows counts twice: sigma is rather too large than too small.
  Advance(turn, belief_);
}

void LiveScale::TurnCamera(double angle) {
  belief_.mean[kDirection] += angle;
  if (provisional_) provisional_->mean[kDirection] += angle;
  for (VehicleStep& step : pending_) step.motion.theta += angle;
}

void LiveScale::EndStraight(int last) {
  const std::vector<VehicleStep> steps = PassOver(last);
  TakeDirection(steps, std::exchange(road_part_, false), belief_);
}

void LiveScale::CutStraight(int last) {
  const bool road_part = road_part_ || ShowsRoad(pending_);
  const std::vector<VehicleStep> steps = PassOver(last);
  // All of them may be of a turn that has begun: no part is cut, and the straight is not one of several parts yet.
  if (steps.empty()) return;
  road_part_ = road_part;
  TakeDirection(steps, road_part, belief_);
}

TurnEnd LiveScale::EndTurn(int last) {
  const std::vector<VehicleStep> steps = PassOver(last);
  TurnUpdate with = WithTurn(belief_, steps);
  belief_ = std::move(with.belief);
  started_ = started_ || with.used;
  KeepProvisional(steps);
  return with.used ? TurnEnd::kUsed : TurnEnd::kNotUsed;
}

std::vector<VehicleStep> LiveScale::PassOver(int last) {
  const int first = steps_ - static_cast<int>(pending_.size());
  const auto after = pending_.begin() + std::max(last - first + 1, 0);
  std::vector<VehicleStep> steps(pending_.begin(), after);
  pending_.erase(pending_.begin(), after);
  Advance(steps, belief_);
  if (TakeRoad(steps, belief_) && KnowsHeight(belief_)) started_ = true;
  return steps;
}

// A straight that has ended shows the direction of travel. Its bends are taken out with the lever arm in units.
void LiveScale::TakeDirection(std::span<const VehicleStep> steps, bool road_part, ScaleBelief& belief) const {
  const std::optional<double> metres_per_unit = MetresPerUnit(steps, belief);
  if (!metres_per_unit) return;
  const double lever_arm = std::exp(belief.mean[kLogLeverArm]) / *metres_per_unit;
  std::optional<StraightDirection> straight = DirectionOnStraight(steps, lever_arm, options_.evidence);
  if (!straight) return;
  if (road_part) ShareDirection(options_.evidence, *straight);
  DriveState at = belief.mean;
  at[kLogScale] = std::log(*metres_per_unit);
  const Measurement measurement = LinearizeStraight(*straight, at, options_.evidence);
  belief = Updated(belief, measurement, RobustWeight(belief, measurement, at, options_.huber), at);
}

void LiveScale::Advance(std::span<const VehicleStep> steps, ScaleBelief& belief) const {
  const std::optional<double> metres_per_unit = MetresPerUnit(steps, belief);
  if (!metres_per_unit) return;
  for (const VehicleStep& step : steps) {
    const PathStretch stretch{step.driven(), std::abs(step.turned()), step.unit_variance, step.gap_sigma};
    belief = Advanced(belief, stretch, *metres_per_unit, options_.drift, options_.evidence.road);
  }
}

std::optional<double> LiveScale::MetresPerUnit(std::span<const VehicleStep> steps, const ScaleBelief& belief) const {
  return started_ ? belief.metres_per_unit() : UsualMetresPerUnit(steps);
}

bool LiveScale::KnowsHeight(const ScaleBelief& belief) const {
  return belief.Sigma(kLogHeight) <= options_.max_sigma && belief.sigma() <= options_.max_sigma;
}

bool LiveScale::TakeRoad(std::span<const VehicleStep> steps, ScaleBelief& belief) const {
  const std::optional<RoadEvidence> road = EvidenceOfRoad(steps, options_.evidence.road);
  if (!road) return false;
  DriveState at = belief.mean;
  if (!started_) at[kLogScale] = at[kLogHeight] - road->log_height;
  const Measurement measurement = LinearizeRoad(*road, at, options_.evidence.road);
  const double weight = started_ ? RobustWeight(belief, measurement, at, options_.huber) : 1.0;
  belief = Updated(belief, measurement, weight, at);
  return true;
}

LiveScale::TurnUpdate LiveScale::WithTurn(const ScaleBelief& belief, std::span<const VehicleStep> steps) const {
  SegmentEvidence evidence = EvidenceOfTurn(steps, options_.evidence);
  const bool used =
      evidence.turn && car_.knows_lever_arm() && WhyUnusable(*evidence.turn, belief.mean, options_.evidence).empty();
  if (!used) {
    // Its direction of travel counts nevertheless, but the part of side slip in it is not known without a scale.
    if (!started_) return {belief};
    evidence.turn.reset();
  }
  ScaleBelief start = belief;
  if (used && !started_ && belief.sigma() > kUnknownScale) {
    // The prior of the scale is arbitrary. What has been related to it moves along: the height, if the road was seen.
    const double log_scale = std::log(OwnScale(*evidence.turn, belief.mean));
    start.mean +=
        start.covariance.col(kLogScale) / start.covariance(kLogScale, kLogScale) * (log_scale - start.mean[kLogScale]);
  }
  ScaleBelief updated = start;
  for (int i = 0; i < kLocalIterations; ++i) {
    const DriveState at = updated.mean;
    updated = start;
    for (const auto& [kind, measurement] : MeasurementsOf(evidence, at, options_.evidence)) {
      // The first turn sets the scale: no prediction of it is there yet, against which to weigh the turn.
      const bool sets_scale = !started_ && kind == kLeverArmOfTurn;
      const double weight = sets_scale ? 1.0 : RobustWeight(start, measurement, at, options_.huber);
      updated = Updated(updated, measurement, weight, at);
    }
    HoldSlip(updated);
  }
  return {updated, used};
}

}  // namespace turnscale
