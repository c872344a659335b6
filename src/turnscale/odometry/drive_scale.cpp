// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_scale.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "turnscale/geometry/angle.h"
#include "turnscale/odometry/drive_steps.h"
#include "turnscale/odometry/scale_refinement.h"

namespace turnscale {
namespace {

// Keyframes from one checkpoint of the filter to the next, at least.
constexpr int kCheckpointInterval = 20;

// Direction of travel under the rotation `now` where it is 0 under the rotation `before`, rad.
double DirectionUnder(const Eigen::Quaterniond& now, const Eigen::Quaterniond& before) {
  const Eigen::Vector3d forward = now * (before.conjugate() * Eigen::Vector3d::UnitZ());
  return std::atan2(forward.x(), forward.z());
}

}  // namespace

DriveScale::DriveScale(const OdometryOptions& options, double aspect_sigma)
    : options_(options),
      aspect_sigma_(aspect_sigma),
      mount_(options.vehicle),
      builder_(options.steps, true),
      live_(PriorOf(options.vehicle, mount_.current(), aspect_sigma), options.scale.estimator),
      live_path_(options.local_bundle.window + options.local_bundle.anchors) {}

bool DriveScale::Add(const Map& map) {
  bool turn_ended = false;
  for (; keyframes_ < CountKeyframes(map); ++keyframes_) {
    const TurnEnd end = Feed(map, keyframes_);
    if (end == TurnEnd::kUsed) unread_turn_ends_.push_back(keyframes_);
    // A keyframe behind a loss of tracking ends a turn that it is no part of.
    used_turn_ended_ = end == TurnEnd::kUsed && !map.keyframes[keyframes_].after_gap;
    turn_ended = turn_ended || end != TurnEnd::kNone;
  }
  UpdateLive(map, {.first = keyframes_});
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
  UpdateLive(map, {.first = keyframes.first, .reread_turn_end = turn_end});
}

void DriveScale::AddJump(const Map& map, int keyframe, const MountJump& jump) {
  mount_.AddJump(keyframe, jump);
  if (checkpoint_ && checkpoint_->keyframe > keyframe) checkpoint_.reset();
  // The jump may have looked like a turn.
  const int begin = Restart();
  std::erase_if(unread_turn_ends_, [begin](int end) { return end >= begin; });
  keyframes_ = begin;
  Add(map);
  std::erase_if(unread_turn_ends_, [this](int end) { return end <= live_path_.last_turn_end(); });
  UpdateLive(map, {.first = begin});
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
  live_ = LiveScale(PriorOf(options_.vehicle, mount_.current(), aspect_sigma_), options_.scale.estimator);
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

void DriveScale::UpdateLive(const Map& map, LivePath::Change change) {
  change.turn_ended = used_turn_ended_;
  live_path_.Update(map, HasMetres(options_.vehicle) ? live_.Now() : std::nullopt, change);
}

RefinedScale DriveScale::Refine(const Map& map, CalibrationVerdict calibration) const {
  return RefineScale(map, mount_, heights_, options_, calibration);
}

}  // namespace turnscale
