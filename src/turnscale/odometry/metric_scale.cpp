// SPDX-License-Identifier: MIT
#include "turnscale/odometry/metric_scale.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turnscale/kinematics/scale_observer.h"
#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/odometry/scale_uncertainty.h"
#include "turnscale/scale/absolute_scale_recovery.h"

namespace turnscale {
namespace {

constexpr int kIterationsBetweenTurns = 10;

LeverArm LeverArmOf(const VehicleOptions& vehicle) { return {vehicle.lever_arm.value_or(0), vehicle.side_slip}; }

TurningRegion KeyframesOf(const TurningRegion& steps) { return {steps.first, steps.last + 1, steps.angle}; }

// Step k of a region leads to keyframe k + 1, which is how the recovery counts.
TurnScale HeldTurn(const TurningRegion& region, double factor) {
  return {region.first + 1, region.last + 1, factor, {}};
}

// The paper's form: every step is held at what its own angles say (22). Steps that say nothing are not held.
void HoldEachStep(const std::vector<TurningStep>& steps, const LeverArm& lever_arm, TurnScale& turn) {
  for (const TurningStep& step : steps) {
    const double distance = step.dt > 0 ? ObservedDistance(step.motion.psi, step.motion.theta, step.dt, lever_arm)
                                        : ObservedDistance(step.motion.psi, step.motion.theta, lever_arm.length);
    turn.distances.push_back(std::isfinite(distance) && distance > 0 ? distance : 0.0);
  }
}

}  // namespace

MetricScale::MetricScale(const OdometryOptions& options) : options_(options), detector_(options.turns) {}

ScaleUpdate MetricScale::AddKeyframe(int keyframe, Map& map) {
  total_factors_.push_back(total_factors_.empty() ? 1.0 : total_factors_.back());
  ScaleUpdate update;
  if (keyframe == 0) return update;
  std::optional<TurningRegion> closed;
  if (map.keyframes[keyframe].after_gap) {
    closed = detector_.AddUnmeasured();
  } else {
    update.motion = MotionOf(map, keyframe - 1);
    closed = detector_.Add(update.motion.psi);
  }
  distance_since_turn_ += update.motion.step;
  if (state_ == ScaleState::kObserved) state_ = ScaleState::kHeld;
  if (closed) update.factors = Close(*closed, map);
  return update;
}

ScaleUpdate MetricScale::Finish(Map& map) {
  ScaleUpdate update;
  if (const std::optional<TurningRegion> closed = detector_.Finish()) {
    update.factors = Close(*closed, map);
  } else if (!map.keyframes.empty()) {
    AdjustSinceLastTurn(map);
    update.factors.assign(map.keyframes.size(), 1.0);
  }
  return update;
}

double MetricScale::sigma() const {
  const Turn* turn = LastUsed();
  if (turn == nullptr) return std::numeric_limits<double>::infinity();
  return std::sqrt(CarriedVariance(options_.scale, turn->relative_sigma, distance_since_turn_));
}

std::vector<double> MetricScale::Close(const TurningRegion& region, Map& map) {
  AdjustSinceLastTurn(map);
  const std::vector<double> unchanged(map.keyframes.size(), 1.0);
  Turn turn;
  turn.region = region;
  TurnResult& result = turn.result;
  result.first_frame = map.keyframes[region.first].frame;
  result.last_frame = map.keyframes[region.last + 1].frame;
  result.keyframes = region.last - region.first + 2;
  result.angle = region.angle;
  if (!options_.vehicle.lever_arm) {
    result.reason = "no lever arm given";
    turns_.push_back(std::move(turn));
    return unchanged;
  }
  const LeverArm lever_arm = LeverArmOf(options_.vehicle);
  const std::vector<TurningStep> steps = StepsOf(map, region);
  const PooledScaleResult pooled = PoolScale(steps, lever_arm, options_.pooled_scale);
  if (!pooled.scale) {
    result.reason = pooled.reason;
    turns_.push_back(std::move(turn));
    return unchanged;
  }
  const double factor = pooled.scale->metres_per_unit;
  turn.relative_sigma = pooled.scale->sigma / factor;
  result.metres_per_unit = factor * total_factors_[region.first];
  result.sigma = turn.relative_sigma * result.metres_per_unit;
  // A turn is held exactly. One that knows the scale far worse than the drive does already would spoil it.
  if (turn.relative_sigma > options_.scale.max_sigma_ratio * sigma()) {
    result.reason = "its scale is less certain than the one carried here";
    turns_.push_back(std::move(turn));
    return unchanged;
  }
  result.used = true;

  std::vector<TurnScale> held;
  int first = 0;
  if (const Turn* previous = LastUsed()) {
    held.push_back(HeldTurn(previous->region, 1.0));
    first = previous->region.first;
  }
  held.push_back(HeldTurn(region, factor));
  if (options_.pooled_scale.method == ScaleMethod::kPerFrame) HoldEachStep(steps, lever_arm, held.back());
  const ScaleRecoveryResult recovered = RecoverAbsoluteScale(options_.scale.recovery, held, first, map);
  for (size_t k = 0; k < total_factors_.size(); ++k) total_factors_[k] *= recovered.factors[k];
  turns_.push_back(std::move(turn));
  state_ = ScaleState::kObserved;
  distance_since_turn_ = 0;
  return recovered.factors;
}

void MetricScale::AdjustSinceLastTurn(Map& map) const {
  const Turn* turn = LastUsed();
  LocalBundleOptions options = options_.local_bundle;
  options.max_iterations = kIterationsBetweenTurns;
  AdjustFrom(options, turn == nullptr ? 0 : turn->region.last + 2, map);
}

TurningMotion MetricScale::MotionOf(const Map& map, int step) const {
  const RigidTransform& previous = map.keyframes[step].camera_from_world;
  const RigidTransform& current = map.keyframes[step + 1].camera_from_world;
  return TurningMotionOf(previous * current.inverse(), options_.vehicle.vehicle_from_camera);
}

std::vector<TurningStep> MetricScale::StepsOf(const Map& map, const TurningRegion& region) const {
  std::vector<TurningStep> steps;
  for (int step = region.first; step <= region.last; ++step)
    steps.push_back({MotionOf(map, step), map.keyframes[step + 1].time - map.keyframes[step].time});
  return steps;
}

const MetricScale::Turn* MetricScale::LastUsed() const {
  const auto used = std::find_if(turns_.rbegin(), turns_.rend(), [](const Turn& turn) { return turn.result.used; });
  return used == turns_.rend() ? nullptr : &*used;
}

std::vector<TurnResult> MetricScale::Turns(const Map& map) const {
  std::vector<TurnResult> results;
  for (const Turn& turn : turns_) {
    results.push_back(turn.result);
    TurnResult& result = results.back();
    if (state_ == ScaleState::kPending) continue;
    const std::vector<TurningStep> steps = StepsOf(map, turn.region);
    double distance = 0;
    for (const TurningStep& step : steps) distance += step.motion.step;
    const double duration = map.keyframes[turn.region.last + 1].time - map.keyframes[turn.region.first].time;
    if (duration > 0) result.speed = distance / duration;
    result.effective_lever_arm = ObservedLeverArm(steps, 1.0, options_.pooled_scale).value_or(0.0);
  }
  return results;
}

void MetricScale::Annotate(const Map& map, const std::vector<int>& keyframe_of_frame,
                           std::vector<FrameResult>& frames) const {
  std::vector<ObservedStretch> observed;
  for (const Turn& turn : turns_)
    if (turn.result.used) {
      const TurningRegion keyframes = KeyframesOf(turn.region);
      observed.push_back({keyframes.first, keyframes.last, turn.relative_sigma});
    }
  const std::vector<double> sigmas = ScaleSigmas(options_.scale, map, observed);
  std::vector<char> turning(map.keyframes.size(), 0);
  for (const Turn& turn : turns_)
    for (int k = turn.region.first; k <= turn.region.last + 1; ++k) turning[k] = turn.result.used ? 2 : 1;
  for (size_t i = 0; i < frames.size(); ++i) {
    FrameResult& frame = frames[i];
    const int keyframe = keyframe_of_frame[i];
    if (keyframe < 0) continue;
    frame.turning = turning[keyframe] != 0;
    frame.scale_sigma = sigmas[keyframe];
    if (!observed.empty()) frame.scale_state = turning[keyframe] == 2 ? ScaleState::kObserved : ScaleState::kHeld;
    if (!frame.keyframe || keyframe == 0 || map.keyframes[keyframe].after_gap) continue;
    const TurningMotion motion = MotionOf(map, keyframe - 1);
    frame.psi = motion.psi;
    frame.theta = motion.theta;
  }
}

}  // namespace turnscale
