// SPDX-License-Identifier: MIT
#include "turnscale/scale/live_scale.h"

#include <algorithm>
#include <cmath>

namespace turnscale {
namespace {

constexpr int kLocalIterations = 5;

}  // namespace

LiveScale::LiveScale(const CarPrior& car, const ScaleEstimatorOptions& options)
    : car_(car), options_(options), detector_(options.segments.turns), belief_(PriorBelief(car, 0)) {}

bool LiveScale::Add(const VehicleStep& step) {
  pending_.push_back(step);
  ++steps_;
  const auto closed = step.usable ? detector_.Add(step.motion.psi) : detector_.AddUnmeasured();
  if (closed) {
    Commit(closed->first - 1, false);
    Commit(closed->last, true);
  } else if (static_cast<int>(pending_.size()) > options_.segments.max_straight_steps) {
    // All but a turn that may have begun.
    Commit(detector_.first_undecided() - 1, false);
  }
  now_ = belief_;
  Advance(pending_, now_);
  known_ = started_;
  turning_ = false;
  if (const auto open = detector_.open()) {
    const int begin = open->first - (steps_ - static_cast<int>(pending_.size()));
    if (const auto with = WithTurn(now_, StepsOf(pending_, begin, begin + open->last - open->first))) {
      now_ = *with;
      known_ = turning_ = true;
    }
  }
  known_ = known_ && now_.sigma() <= options_.max_sigma;
  return closed.has_value();
}

std::optional<ScaleBelief> LiveScale::Now() const { return known_ ? std::optional(now_) : std::nullopt; }

// The pending steps up to `last` become a segment.
void LiveScale::Commit(int last, bool turning) {
  const int first = steps_ - static_cast<int>(pending_.size());
  if (last < first) return;
  const auto end = pending_.begin() + (last - first + 1);
  const std::vector<VehicleStep> steps(pending_.begin(), end);
  pending_.erase(pending_.begin(), end);
  Advance(steps, belief_);
  if (!turning) return;
  if (const auto with = WithTurn(belief_, steps)) {
    belief_ = *with;
    started_ = true;
  }
}

void LiveScale::Advance(const std::vector<VehicleStep>& steps, ScaleBelief& belief) const {
  if (!started_) return;
  for (const VehicleStep& step : steps)
    belief.covariance(kLogScale, kLogScale) += DriftVariance(options_.drift, step.motion.step, belief.metres_per_unit(),
                                                             std::abs(step.motion.psi), step.gap_sigma);
}

std::optional<ScaleBelief> LiveScale::WithTurn(const ScaleBelief& belief, const std::vector<VehicleStep>& steps) const {
  const SegmentEvidence evidence = EvidenceOfTurn(steps, options_.evidence);
  if (!evidence.turn) return std::nullopt;
  ScaleBelief start = belief;
  const double own = OwnScale(evidence, belief.mean);
  const LeverArm lever_arm{car_.lever_arm, std::max(belief.mean[kSlip], 0.0)};
  if (!std::isfinite(own) || LeverArmRatio(*evidence.turn, lever_arm, own) < options_.evidence.min_lever_arm_ratio)
    return std::nullopt;
  if (!started_) start.mean[kLogScale] = std::log(own);
  ScaleBelief updated = start;
  double weight = 1;
  for (int i = 0; i < kLocalIterations; ++i) {
    const DriveState at = updated.mean;
    const auto measurement = Linearize(evidence, at, options_.evidence);
    if (started_) {
      // What the filter expects may be as wrong as the turn: the deviation is that of both together.
      const double variance =
          measurement->variance + measurement->by_state.dot(start.covariance * measurement->by_state.transpose());
      const double innovation = measurement->innovation - measurement->by_state.dot(start.mean - at);
      weight = std::min(1.0, options_.huber / std::max(std::abs(innovation) / std::sqrt(variance), 1e-9));
    }
    updated = Updated(start, *measurement, weight, at);
  }
  return updated;
}

}  // namespace turnscale
