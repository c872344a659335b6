// SPDX-License-Identifier: MIT
#include "turnscale/odometry/metric_scale.h"

#include <algorithm>
#include <cmath>

#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/odometry/drive_scale.h"
#include "turnscale/odometry/turn_reading.h"
#include "turnscale/scale/absolute_scale_recovery.h"
#include "turnscale/scale/map_scaling.h"

namespace turnscale {
namespace {

constexpr int kIterationsBetweenTurns = 10;

LeverArm LeverArmOf(const VehicleOptions& vehicle) { return {vehicle.lever_arm.value_or(0), vehicle.side_slip}; }

TurningRegion KeyframesOf(const TurningRegion& steps) { return {steps.first, steps.last + 1, steps.angle}; }

// `by` may be empty, and then changes nothing.
void Multiply(const std::vector<double>& by, std::vector<double>& factors) {
  for (size_t k = 0; k < by.size() && k < factors.size(); ++k) factors[k] *= by[k];
}

}  // namespace

MetricScale::MetricScale(const OdometryOptions& options)
    : options_(options), detector_(options.turns), mount_(options.vehicle) {}

ScaleUpdate MetricScale::AddKeyframe(int keyframe, Map& map) {
  total_factors_.push_back(total_factors_.empty() ? 1.0 : total_factors_.back());
  ScaleUpdate update;
  if (keyframe == 0) return update;
  std::optional<TurningRegion> closed;
  if (map.keyframes[keyframe].after_gap) {
    closed = detector_.AddUnmeasured();
  } else {
    update.motion = StepMotion(map, keyframe - 1, mount_);
    closed = detector_.Add(update.motion.psi);
  }
  since_turn_.distance += update.motion.step;
  if (map.keyframes[keyframe].after_gap) ++since_turn_.gaps;
  if (state_ == ScaleState::kObserved) state_ = ScaleState::kHeld;
  if (closed) update.factors = Close(*closed, map);
  return update;
}

ScaleUpdate MetricScale::EndPath(Map& map) {
  ScaleUpdate update;
  if (map.keyframes.empty()) return update;
  if (const std::optional<TurningRegion> closed = detector_.Finish()) {
    update.factors = Close(*closed, map);
  } else {
    update.factors = AdjustSinceLastTurn(map);
    Multiply(update.factors, total_factors_);
    const int last = static_cast<int>(map.keyframes.size()) - 1;
    if (mount_.Learn(map, total_factors_, last)) ReadTurns(0, map, update.factors);
  }
  return update;
}

ScaleUpdate MetricScale::Finish(Map& map) {
  ScaleUpdate update = EndPath(map);
  if (options_.Smooths()) ReadTurns(0, map, update.factors);
  return update;
}

double MetricScale::sigma() const {
  const Turn* turn = LastUsedBefore(static_cast<int>(turns_.size()));
  if (turn == nullptr) return std::numeric_limits<double>::infinity();
  return std::sqrt(CarriedVariance(options_.scale, turn->relative_sigma, since_turn_));
}

std::vector<double> MetricScale::Close(const TurningRegion& region, Map& map) {
  std::vector<double> factors = AdjustSinceLastTurn(map);
  Multiply(factors, total_factors_);
  const bool mount_changed = mount_.Learn(map, total_factors_, region.last + 1);
  const int newest = static_cast<int>(turns_.size());
  Turn& turn = turns_.emplace_back();
  turn.region = region;
  turn.result.first_frame = map.keyframes[region.first].frame;
  turn.result.last_frame = map.keyframes[region.last + 1].frame;
  turn.result.keyframes = region.last - region.first + 2;
  turn.result.angle = region.angle;
  ReadTurns(mount_changed ? 0 : newest, map, factors);
  if (turns_.back().result.used) {
    CarryFrom(region, map);
    state_ = ScaleState::kObserved;
  }
  return factors;
}

void MetricScale::ReadTurns(int from, Map& map, std::vector<double>& factors) {
  std::vector<TurnScale> held;
  int first_keyframe = 0;
  if (const Turn* previous = LastUsedBefore(from)) {
    held.push_back(AsRecovered(*previous));
    first_keyframe = previous->region.first;
  }
  std::vector<int> told;
  for (int i = from; i < static_cast<int>(turns_.size()); ++i) {
    const std::optional<TurnScale> scale = Read(map, turns_[i]);
    if (!scale) continue;
    held.push_back(*scale);
    told.push_back(i);
  }
  if (told.empty()) return;
  if (options_.Smooths()) WeighSmoothly(map, told, std::span(held).last(told.size()));
  const ScaleRecoveryResult recovered = RecoverAbsoluteScale(options_.scale.recovery, held, first_keyframe, map);
  Multiply(recovered.factors, factors);
  Multiply(recovered.factors, total_factors_);
  for (int i = 0; i < static_cast<int>(turns_.size()); ++i) {
    Turn& turn = turns_[i];
    if (!turn.result.used || turn.region.first < first_keyframe) continue;
    turn.step_lengths.clear();
    for (const TurningStep& step : StepsOfTurn(map, turn.region, mount_)) turn.step_lengths.push_back(step.motion.step);
    if (i < from) continue;
    turn.result.unadjusted.clear();
    for (const RangeRecovery& range : recovered.ranges) {
      const bool around = range.range.first <= turn.region.first && turn.region.first < range.range.last;
      if (around && !range.adjusted) turn.result.unadjusted = range.reason;
    }
  }
  if (state_ == ScaleState::kPending) CarryFrom(turns_[told.back()].region, map);
}

// From that turn on to the latest keyframe.
void MetricScale::CarryFrom(const TurningRegion& region, const Map& map) {
  state_ = ScaleState::kHeld;
  since_turn_ = {};
  for (int step = region.last + 1; step + 1 < static_cast<int>(map.keyframes.size()); ++step) {
    since_turn_.distance += StepMotion(map, step, mount_).step;
    if (map.keyframes[step + 1].after_gap) ++since_turn_.gaps;
  }
}

std::optional<TurnScale> MetricScale::Read(const Map& map, Turn& turn) const {
  TurnResult& result = turn.result;
  const bool refused_before = !result.used && result.metres_per_unit > 0;
  if (!options_.vehicle.lever_arm) {
    result.reason = "no lever arm given";
    return std::nullopt;
  }
  const std::vector<TurningStep> steps = StepsOfTurn(map, turn.region, mount_);
  const PooledScaleResult pooled = PoolScale(steps, LeverArmOf(options_.vehicle), options_.pooled_scale);
  if (!pooled.scale) {
    if (result.used) return AsRecovered(turn);
    result.reason = pooled.reason;
    return std::nullopt;
  }
  const double factor = pooled.scale->metres_per_unit;
  turn.relative_sigma = pooled.scale->sigma / factor;
  result.metres_per_unit = factor * total_factors_[turn.region.first];
  result.sigma = turn.relative_sigma * result.metres_per_unit;
  // Held at what it says itself, a turn that knows the scale far worse than the drive does already would spoil it.
  const bool poor = refused_before || turn.relative_sigma > options_.scale.max_sigma_ratio * sigma();
  if (!options_.Smooths() && !result.used && poor) {
    result.reason = "its scale is less certain than the one carried here";
    return std::nullopt;
  }
  result.used = true;
  result.reason.clear();
  TurnScale held = HeldTurn(turn.region, factor);
  if (options_.Smooths()) held.sigma = turn.relative_sigma;
  if (options_.pooled_scale.method == ScaleMethod::kPerFrame) HoldEachStep(steps, LeverArmOf(options_.vehicle), held);
  return held;
}

void MetricScale::WeighSmoothly(const Map& map, const std::vector<int>& turns, std::span<TurnScale> held) {
  smoothed_sigmas_.clear();
  car_.reset();
  const std::optional<DriveScale> drive = DriveScaleOf(map, total_factors_, mount_, options_);
  if (!drive) return;
  const std::vector<PoseScale>& scales = drive->keyframes;
  car_ = drive->car;
  for (const PoseScale& scale : scales) smoothed_sigmas_.push_back(scale.sigma);
  for (size_t i = 0; i < turns.size(); ++i) {
    if (WeighSmoothed(scales, map, total_factors_, held[i]))
      turns_[turns[i]].relative_sigma = scales[held[i].last_step].sigma;
  }
}

TurnScale MetricScale::AsRecovered(const Turn& turn) {
  TurnScale held = HeldTurn(turn.region, 1.0);
  held.distances = turn.step_lengths;
  return held;
}

std::vector<double> MetricScale::AdjustSinceLastTurn(Map& map) const {
  LocalBundleOptions options = options_.local_bundle;
  options.max_iterations = kIterationsBetweenTurns;
  const int first = turns_.empty() ? 0 : turns_.back().region.last + 2;
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(map);
  AdjustFrom(options, first, map);
  return KeyframeFactors(before, KeyframeCentres(map), first, std::vector<double>(before.size(), 1.0));
}

const MetricScale::Turn* MetricScale::LastUsedBefore(int turn) const {
  for (int i = turn; i-- > 0;)
    if (turns_[i].result.used) return &turns_[i];
  return nullptr;
}

std::vector<TurnResult> MetricScale::Turns(const Map& map) const {
  std::vector<TurnResult> results;
  for (const Turn& turn : turns_) {
    results.push_back(turn.result);
    TurnResult& result = results.back();
    if (state_ == ScaleState::kPending) continue;
    const std::vector<TurningStep> steps = StepsOfTurn(map, turn.region, mount_);
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
  std::vector<double> sigmas = ScaleSigmas(options_.scale, map, observed);
  // What turns have in common does not average out between them, which the smoothed sigmas know.
  std::copy(smoothed_sigmas_.begin(), smoothed_sigmas_.end(), sigmas.begin());
  std::vector<char> in_used_turn(map.keyframes.size(), 0);
  std::vector<char> turning(map.keyframes.size(), 0);
  for (const Turn& turn : turns_) {
    const TurningRegion keyframes = KeyframesOf(turn.region);
    // A turn's scale holds from the keyframe that its first step leaves; what turns are its steps.
    for (int k = keyframes.first; k <= keyframes.last; ++k) {
      if (turn.result.used) in_used_turn[k] = 1;
      if (k > keyframes.first) turning[k] = 1;
    }
  }
  int keyframe = -1;
  for (size_t i = frames.size(); i-- > 0;) {
    // From the end, since frames before the first keyframe go with it.
    FrameResult& frame = frames[i];
    if (keyframe_of_frame[i] >= 0) keyframe = keyframe_of_frame[i];
    if (keyframe < 0) continue;
    frame.vehicle_from_camera = mount_.At(keyframe);
    frame.turning = turning[keyframe] != 0;
    frame.scale_sigma = sigmas[keyframe];
    if (!observed.empty()) frame.scale_state = in_used_turn[keyframe] != 0 ? ScaleState::kObserved : ScaleState::kHeld;
    if (!frame.keyframe || keyframe == 0 || map.keyframes[keyframe].after_gap) continue;
    const TurningMotion motion = StepMotion(map, keyframe - 1, mount_);
    frame.psi = motion.psi;
    frame.theta = motion.theta;
  }
}

}  // namespace turnscale
