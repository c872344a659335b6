// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_scale.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turnscale/geometry/angle.h"
#include "turnscale/scale/scale_track.h"

namespace turnscale {
namespace {

// Keyframes back to which a turn may change the live scale: on a long straight the path before it stays.
constexpr int kMostRevised = 500;

// Keyframes from one checkpoint of the filter to the next, at least.
constexpr int kCheckpointInterval = 20;

// Turns are found with any lever arm: that of a car without a length in metres, whose scale nobody reads.
constexpr double kAnyLeverArm = 1;

double YawSigma(const VehicleOptions& vehicle, const Mount& mount) {
  if (!vehicle.calibrate_camera) return vehicle.yaw_sigma;
  if (mount.found) return PriorYawSigma(mount.sigma.yaw, vehicle.yaw_sigma);
  const bool as_given = vehicle.camera_known && mount.first_keyframe == 0;
  return as_given ? vehicle.yaw_sigma : std::max(vehicle.yaw_sigma, kYawSigmaByEye);
}

CarPrior PriorOf(const VehicleOptions& vehicle, const Mount& mount) {
  CarPrior car;
  car.lever_arm = vehicle.lever_arm.value_or(vehicle.camera_height ? 0.0 : kAnyLeverArm);
  car.lever_arm_sigma = vehicle.lever_arm ? vehicle.LeverArmSigma() : TapeSigma(car.lever_arm);
  if (vehicle.camera_height) {
    car.camera_height = *vehicle.camera_height;
    car.camera_height_sigma = vehicle.HeightSigma();
    car.height_correlation = vehicle.height_correlation;
    car.height_slip_correlation = vehicle.height_slip_correlation;
  }
  car.side_slip = vehicle.side_slip;
  car.side_slip_sigma = vehicle.side_slip_sigma;
  if (vehicle.lever_arm) car.lever_arm_slip_correlation = vehicle.lever_arm_slip_correlation;
  car.yaw_sigma = YawSigma(vehicle, mount);
  car.roll_height = vehicle.roll_height;
  car.roll_height_sigma = vehicle.roll_height_sigma;
  car.image_lag = vehicle.image_lag;
  car.image_lag_sigma = vehicle.image_lag_sigma;
  return car;
}

// Direction of travel under the rotation `now` where it is 0 under the rotation `before`, rad.
double DirectionUnder(const Eigen::Quaterniond& now, const Eigen::Quaterniond& before) {
  const Eigen::Vector3d forward = now * (before.conjugate() * Eigen::Vector3d::UnitZ());
  return std::atan2(forward.x(), forward.z());
}

// Position of the camera in the vehicle's axes, which may change on the way where the camera was moved.
StampedPose VehiclePose(const Map& map, const MountCalibration& mount, int keyframe) {
  const RigidTransform pose = map.keyframes[keyframe].camera_from_world.inverse();
  return {map.keyframes[keyframe].time, {pose.rotation * mount.At(keyframe).conjugate(), pose.translation}};
}

std::optional<PathGap> GapBefore(const Map& map, int keyframe) {
  if (keyframe == 0 || !map.keyframes[keyframe].after_gap) return std::nullopt;
  return PathGap{keyframe, map.keyframes[keyframe].gap_sigma};
}

// How well the landmarks determine the unit of length along a step.
void SetUnitVariance(const Map& map, const DriftOptions& drift, VehicleStep& step) {
  if (step.after_gap) return;
  // With a standard deviation of 1 of its logarithm, the unit is unknown.
  constexpr double kMostVariance = 1;
  double variance = 0;
  for (int k = step.first + 1; k <= step.last; ++k)
    variance += std::min(map.keyframes[k].pixel_unit_variance, kMostVariance);
  step.unit_variance = std::min(drift.unit_inflation * drift.unit_inflation * variance, kMostVariance);
}

// What the map says of a step beside its motion, for the live and the refined scale alike.
void CompleteStep(const Map& map, const std::vector<MeasuredHeight>& heights, const DriftOptions& drift,
                  VehicleStep& step) {
  SetStepHeight(map, heights, step);
  SetUnitVariance(map, drift, step);
}

// Of the keyframe, or of the last one before it that is finite.
Eigen::Vector3d KnownCentre(const Map& map, int keyframe) {
  while (keyframe > 0 && !Centre(map.keyframes[keyframe]).allFinite()) --keyframe;
  return Centre(map.keyframes[keyframe]);
}

// A length in metres, from which the scale may come.
bool HasMetres(const VehicleOptions& vehicle) { return vehicle.lever_arm || vehicle.camera_height; }

// Leaves the turns.
void ForgetScale(const std::string& reason, ScaleEstimateResult& result) {
  result.estimate.reset();
  result.reason = reason;
  for (TurnEstimate& turn : result.detected_turns) {
    turn.used = turn.used_singly = false;
    turn.reason = reason;
    turn.own = turn.own_relative_sigma = turn.as_given = 0;
  }
}

std::vector<VehicleStep> StepsAlong(const Map& map, const MountCalibration& mount,
                                    const std::vector<MeasuredHeight>& heights, const OdometryOptions& options) {
  Trajectory path;
  std::vector<PathGap> gaps;
  for (int k = 0; k < CountKeyframes(map); ++k) {
    path.push_back(VehiclePose(map, mount, k));
    if (const auto gap = GapBefore(map, k)) gaps.push_back(*gap);
  }
  std::vector<VehicleStep> steps = CutIntoSteps(path, gaps, true, options.steps);
  for (VehicleStep& step : steps) CompleteStep(map, heights, options.scale.estimator.drift, step);
  return steps;
}

MetricPath InOwnUnit(const Map& map) {
  MetricPath path;
  for (int k = 0; k < CountKeyframes(map); ++k) path.centres.push_back(KnownCentre(map, k));
  path.metres_per_unit.assign(map.keyframes.size(), 1.0);
  return path;
}

}  // namespace

TurnResult DescribeTurn(const TurnEstimate& turn, const std::vector<VehicleStep>& steps,
                        const std::function<int(int keyframe)>& frame_of) {
  TurnResult result;
  result.first_keyframe = steps[turn.first_step].first;
  result.last_keyframe = steps[turn.last_step].last;
  result.first_frame = frame_of(result.first_keyframe);
  result.last_frame = frame_of(result.last_keyframe);
  result.angle = turn.angle;
  result.used = turn.used;
  result.reason = turn.reason;
  result.speed = turn.speed_units * turn.smoothed;
  result.own = turn.own;
  result.as_given = turn.as_given;
  result.used_singly = turn.used_singly;
  result.own_sigma = turn.own_relative_sigma * turn.own;
  result.smoothed = turn.smoothed;
  result.smoothed_sigma = turn.smoothed_relative_sigma * turn.smoothed;
  result.deviation = turn.deviation;
  result.effective_lever_arm = turn.lever_arm_units * turn.smoothed;
  return result;
}

DriveScale::DriveScale(const OdometryOptions& options)
    : options_(options),
      mount_(options.vehicle),
      builder_(options.steps, true),
      live_(PriorOf(options.vehicle, mount_.current()), options.scale.estimator) {}

bool DriveScale::Add(const Map& map) {
  bool turn_ended = false;
  for (; keyframes_ < CountKeyframes(map); ++keyframes_) {
    const TurnEnd end = Feed(map, keyframes_);
    if (end == TurnEnd::kUsed) unread_turn_ends_.push_back(keyframes_);
    // A keyframe behind a loss of tracking ends a turn that it is no part of.
    used_turn_ended_ = end == TurnEnd::kUsed && !map.keyframes[keyframes_].after_gap;
    turn_ended = turn_ended || end != TurnEnd::kNone;
  }
  UpdateLive(map, keyframes_);
  return turn_ended;
}

void DriveScale::Reread(const Map& map) {
  checkpoint_.reset();
  const int keyframes = CountKeyframes(map);
  MountCalibration mount = mount_;
  mount.Learn(map, keyframes - 1);
  Reread(map, std::move(mount), {.first = 0, .end = keyframes, .final_before = 0});
}

void DriveScale::Reread(const Map& map, MountCalibration mount, const ReadjustedKeyframes& keyframes) {
  const auto knowledge = [&] { return std::pair(mount_.moves(), YawSigma(options_.vehicle, mount_.current())); };
  const auto before = knowledge();
  // What has been learned without knowing of a jump is wrong; these keyframes are learned from next time.
  if (!mount_.HasJumpsMissedBy(mount)) {
    mount.TakeJumps(mount_);
    mount_ = std::move(mount);
  }
  // A move is found many keyframes after it.
  if (mount_.moves() > 0)
    std::erase_if(heights_, [moved = mount_.mounts()[1].first_keyframe](const MeasuredHeight& height) {
      return height.keyframe >= moved;
    });
  // Another prior of the yaw counts from the start on.
  if (knowledge() != before) checkpoint_.reset();
  const int begin = Restart();
  keyframes_ = CountKeyframes(map);
  for (int k = begin; k < keyframes_; ++k) {
    if (k == keyframes.final_before && k - begin >= kCheckpointInterval)
      checkpoint_ = Checkpoint{k, builder_, live_, mount_.At(k)};
    Feed(map, k);
  }
  const auto unread = std::ranges::lower_bound(unread_turn_ends_, keyframes.end);
  const std::optional<int> turn_end = unread == unread_turn_ends_.begin() ? std::nullopt : std::optional(*(unread - 1));
  unread_turn_ends_.erase(unread_turn_ends_.begin(), unread);
  UpdateLive(map, keyframes.first, turn_end);
  if (turn_end) last_turn_end_ = *turn_end;
}

void DriveScale::AddJump(const Map& map, int keyframe, const MountJump& jump) {
  mount_.AddJump(keyframe, jump);
  if (checkpoint_ && checkpoint_->keyframe > keyframe) checkpoint_.reset();
  // The jump may have looked like a turn.
  const int begin = Restart();
  std::erase_if(unread_turn_ends_, [begin](int end) { return end >= begin; });
  keyframes_ = begin;
  Add(map);
  std::erase_if(unread_turn_ends_, [this](int end) { return end <= last_turn_end_; });
  UpdateLive(map, begin);
}

int DriveScale::Restart() {
  // A rotation that has changed by more is not only turned: the steps were levelled and cut under another one.
  constexpr double kMostTurned = 0.3 / kDegreesPerRadian;
  if (checkpoint_) {
    const Eigen::Quaterniond now = mount_.At(checkpoint_->keyframe);
    const Eigen::Quaterniond& then = checkpoint_->vehicle_from_camera;
    if (then.angularDistance(now) <= kMostTurned) {
      builder_ = checkpoint_->builder;
      builder_.TurnAxes(then * now.conjugate());
      live_ = checkpoint_->live;
      live_.TurnCamera(DirectionUnder(now, then));
      return checkpoint_->keyframe;
    }
    checkpoint_.reset();
  }
  builder_ = StepBuilder(options_.steps, true);
  live_ = LiveScale(PriorOf(options_.vehicle, mount_.current()), options_.scale.estimator);
  return 0;
}

TurnEnd DriveScale::Feed(const Map& map, int keyframe) {
  const std::optional<PathGap> gap = GapBefore(map, keyframe);
  TurnEnd turn_end = TurnEnd::kNone;
  const std::optional<double> gap_sigma = gap ? std::optional(gap->sigma) : std::nullopt;
  for (VehicleStep& step : builder_.Add(VehiclePose(map, mount_, keyframe), gap_sigma)) {
    CompleteStep(map, heights_, options_.scale.estimator.drift, step);
    const TurnEnd end = live_.Add(step);
    if (end != TurnEnd::kNone) turn_end = end;
  }
  return turn_end;
}

void DriveScale::UpdateLive(const Map& map, int first, std::optional<int> turn_end) {
  const std::optional<LiveReading> now = HasMetres(options_.vehicle) ? live_.Now() : std::nullopt;
  const bool was_known = state_ != ScaleState::kPending;
  const double scale = now ? now->belief.metres_per_unit() : 1.0;
  sigma_ = now ? now->belief.sigma() : std::numeric_limits<double>::infinity();
  state_ = now ? now->state : ScaleState::kPending;
  if (now && used_turn_ended_) state_ = ScaleState::kObserved;

  const int count = CountKeyframes(map);
  std::vector<double>& scales = live_path_.metres_per_unit;
  scales.resize(count, scale);
  live_path_.centres.resize(count);
  // Local bundle adjustment may still move the keyframes of its window.
  first = std::max(0, std::min(first, count) - 1 - options_.local_bundle.window - options_.local_bundle.anchors);
  if (was_known != now.has_value()) {
    std::ranges::fill(scales, scale);
    first = 0;
  } else if (turn_end || state_ == ScaleState::kObserved) {
    first = std::min(first, SpreadScale(map, scale, turn_end.value_or(count - 1)));
  }
  if (first == 0) live_path_.centres[0] = scales[0] * Centre(map.keyframes[0]);
  for (int k = first + 1; k < count; ++k) {
    // The bridged step is predicted, in the unit before the gap.
    const double metres_per_unit = map.keyframes[k].after_gap ? scales[k - 1] : scales[k];
    live_path_.centres[k] =
        live_path_.centres[k - 1] + metres_per_unit * (KnownCentre(map, k) - KnownCentre(map, k - 1));
  }
}

// From the end of the turn before the scale passes evenly to that of the turn under way; at a loss of tracking it
// changes at once.
int DriveScale::SpreadScale(const Map& map, double scale, int last) {
  const int begin = std::max(last_turn_end_, last - kMostRevised);
  if (last <= begin) return begin;
  std::vector<double>& scales = live_path_.metres_per_unit;
  std::fill(scales.begin() + last, scales.end(), scale);
  int gap = last;
  while (gap > begin && !map.keyframes[gap].after_gap) --gap;
  if (gap > begin) {
    std::fill(scales.begin() + gap, scales.begin() + last, scale);
    return begin;
  }
  std::vector<double> length(last - begin + 1, 0.0);  // from `begin` on
  for (int k = begin + 1; k <= last; ++k)
    length[k - begin] = length[k - begin - 1] + (KnownCentre(map, k) - KnownCentre(map, k - 1)).norm();
  const double growth = std::log(scale / scales[begin]);
  for (int k = begin + 1; k <= last; ++k)
    scales[k] = scales[begin] * std::exp(length.back() > 0 ? growth * length[k - begin] / length.back() : growth);
  return begin;
}

RefinedScale DriveScale::Refine(const Map& map, bool has_known_errors) const {
  RefinedScale refined;
  const int count = CountKeyframes(map);
  refined.path = InOwnUnit(map);
  refined.keyframes.resize(count);
  const std::vector<VehicleStep> steps = StepsAlong(map, mount_, heights_, options_);
  if (steps.empty()) {
    refined.reason = "the trajectory has no usable step";
    return refined;
  }
  ScaleEstimatorOptions estimator = options_.scale.estimator;
  estimator.uses_single_turns =
      estimator.uses_single_turns || has_known_errors || options_.scale.method != ScaleMethod::kSmoothed;
  estimator.stabilisation.enabled = estimator.stabilisation.enabled && !has_known_errors;
  ScaleEstimateResult result = EstimateScale(steps, PriorOf(options_.vehicle, mount_.current()), estimator);
  if (!HasMetres(options_.vehicle)) ForgetScale("no lever arm given", result);
  const auto frame_of = [&](int keyframe) { return map.keyframes[keyframe].frame; };
  for (const TurnEstimate& turn : result.estimate ? result.estimate->turns : result.detected_turns) {
    const TurnResult& described = refined.turns.emplace_back(DescribeTurn(turn, steps, frame_of));
    for (int k = described.first_keyframe + 1; k <= described.last_keyframe; ++k) refined.keyframes[k].turning = true;
  }
  refined.reason = result.reason;
  if (!result.estimate) return refined;
  const std::vector<PoseScale> scales = ScaleTrack(count, steps, *result.estimate);
  refined.path.centres = MetricPositions(refined.path.centres, scales);
  for (int k = 0; k < count; ++k) {
    refined.path.metres_per_unit[k] = scales[k].metres_per_unit;
    refined.keyframes[k].sigma = scales[k].sigma;
    refined.keyframes[k].state = scales[k].from_road ? ScaleState::kFromRoad : ScaleState::kHeld;
  }
  for (const TurnResult& turn : refined.turns)
    for (int k = turn.first_keyframe; turn.used && k <= turn.last_keyframe; ++k)
      refined.keyframes[k].state = ScaleState::kObserved;
  refined.estimate = std::move(result.estimate);
  return refined;
}

TurningMotion StepMotion(const Map& map, int step, const MountCalibration& mount) {
  const RigidTransform& previous = map.keyframes[step].camera_from_world;
  const RigidTransform& current = map.keyframes[step + 1].camera_from_world;
  RigidTransform previous_from_current = previous * current.inverse();
  const Eigen::Quaterniond before = mount.At(step);
  const Eigen::Quaterniond after = mount.At(step + 1);
  if (before.coeffs() == after.coeffs()) return TurningMotionOf(previous_from_current, after);
  previous_from_current.rotation = previous_from_current.rotation * (after.conjugate() * before);
  return TurningMotionOf(previous_from_current, before);
}

}  // namespace turnscale
