// SPDX-License-Identifier: MIT
#include "turnscale/calibration/camera_step.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Speeds within 5 % are counted together.
constexpr double kSame = 0.05;

bool Finite(const StampedPose& pose) { return std::isfinite(pose.time) && pose.world_from_camera.IsFinite(); }

void CheckPose(const std::optional<StampedPose>& last, const StampedPose& pose) {
  if (!Finite(pose)) throw InputError("the pose at time " + std::to_string(pose.time) + " s is not finite");
  if (last && pose.time <= last->time) {
    throw InputError("time " + std::to_string(pose.time) + " s does not come after " + std::to_string(last->time) +
                     " s");
  }
}

double Distance(const StampedPose& a, const StampedPose& b) {
  return (b.world_from_camera.translation - a.world_from_camera.translation).norm();
}

bool TooFast(double way, double seconds, double usual_speed, const StepOptions& options) {
  return usual_speed > 0 && way > options.max_haste * usual_speed * seconds;
}

// A frame falls short of the wanted length by rounding as often as not.
bool LongEnough(double way, double usual_speed, const StepOptions& options) {
  return usual_speed > 0 && way > 0.99 * options.duration * usual_speed;
}

bool TooSlow(double seconds, const StepOptions& options) { return seconds > options.max_slowness * options.duration; }

UsualSpeed UsualSpeedOf(const std::vector<Trajectory>& stretches) {
  UsualSpeed speed;
  for (const Trajectory& path : stretches) {
    for (size_t i = 0; i < path.size(); ++i) {
      CheckPose(i > 0 ? std::optional(path[i - 1]) : std::nullopt, path[i]);
      if (i > 0) speed.Add(Distance(path[i - 1], path[i]), path[i].time - path[i - 1].time);
    }
  }
  return speed;
}

// Takes the motion between two frames; gives the step that it completes.
std::optional<CameraStep> Gather(const StampedPose& last, const StampedPose& pose, double usual_speed,
                                 const StepOptions& options, FrameMotions& open) {
  if (open.frames == 0) open.begin = last.time;
  const RigidTransform motion = last.world_from_camera.inverse() * pose.world_from_camera;
  const Eigen::Vector3d rotation = VectorFromRotation(motion.rotation);
  open.rotation += rotation;
  open.translation += RotationFromVector(-0.5 * rotation) * motion.translation;
  ++open.frames;
  const bool long_enough = LongEnough(open.translation.norm(), usual_speed, options);
  const bool too_slow = TooSlow(pose.time - open.begin, options);
  const bool too_fast = TooFast(motion.translation.norm(), pose.time - last.time, usual_speed, options);
  if (!long_enough && !too_slow && !too_fast) return std::nullopt;
  const FrameMotions closed = open;
  open = FrameMotions();
  if (!long_enough || too_slow || too_fast) return std::nullopt;
  const double share = 1.0 / closed.frames;
  const Eigen::Vector3d turn = share * closed.rotation;
  return CameraStep{{RotationFromVector(turn), share * (RotationFromVector(0.5 * turn) * closed.translation)},
                    closed.frames,
                    closed.begin,
                    pose.time};
}

}  // namespace

UsualSpeed::UsualSpeed(double memory) : memory_(memory) {}

void UsualSpeed::Add(double way, double seconds) {
  if (!(way > 0)) return;
  const double speed = way / seconds;
  if (!reference_) reference_ = speed;
  if (std::isfinite(memory_) && value_ > 0) {
    // By the way driven, so that no time of standing makes the driving forgotten.
    const double kept = std::exp(-way / (memory_ * value_));
    for (auto& [ratio, driven] : by_speed_) driven = {kept * driven.way, kept * driven.seconds};
    way_ *= kept;
    constexpr double kNothing = 1e-6;
    std::erase_if(by_speed_, [this](const auto& entry) { return entry.second.way < kNothing * way_; });
  }
  constexpr double kMostApart = 1000;
  const double apart = std::clamp(std::log(speed / *reference_) / kSame, -kMostApart, kMostApart);
  Driven& driven = by_speed_[static_cast<int>(std::floor(apart))];
  driven.way += way;
  driven.seconds += seconds;
  way_ += way;
  double faster = 0;
  for (const auto& [place, speed_class] : by_speed_) {
    faster += speed_class.way;
    value_ = speed_class.way / speed_class.seconds;
    if (faster >= 0.5 * way_) break;
  }
}

void StepOptions::Check() const {
  if (!(duration > 0) || !std::isfinite(duration)) throw InputError("duration: must be above 0 s");
  if (!(max_slowness >= 1)) throw InputError("max_slowness: must be at least 1");
  if (!(max_haste > 1)) throw InputError("max_haste: must be above 1");
  if (!(speed_memory > 0)) throw InputError("speed_memory: must be above 0 s");
}

StepGatherer::StepGatherer(const StepOptions& options) : options_(options), speed_(options.speed_memory) {
  options_.Check();
}

std::optional<CameraStep> StepGatherer::Add(const StampedPose& pose) {
  CheckPose(last_, pose);
  std::optional<CameraStep> step;
  if (last_) {
    speed_.Add(Distance(*last_, pose), pose.time - last_->time);
    step = Gather(*last_, pose, speed_.value(), options_, open_);
  }
  last_ = pose;
  return step;
}

void StepGatherer::Break() {
  last_.reset();
  open_ = FrameMotions();
}

std::vector<CameraStep> StepsAlong(const Trajectory& trajectory, const StepOptions& options) {
  return StepsAlong(std::vector<Trajectory>{trajectory}, options);
}

std::vector<CameraStep> StepsAlong(const std::vector<Trajectory>& stretches, const StepOptions& options) {
  options.Check();
  const double usual_speed = UsualSpeedOf(stretches).value();
  std::vector<CameraStep> steps;
  for (const Trajectory& path : stretches) {
    FrameMotions open;
    for (size_t i = 1; i < path.size(); ++i) {
      const auto step = Gather(path[i - 1], path[i], usual_speed, options, open);
      if (step) steps.push_back(*step);
    }
  }
  return steps;
}

std::optional<double> FirstGap(const Trajectory& trajectory, const StepOptions& options) {
  options.Check();
  const double usual_speed = UsualSpeedOf({trajectory}).value();
  for (size_t i = 1; i < trajectory.size(); ++i) {
    const double way = Distance(trajectory[i - 1], trajectory[i]);
    const double seconds = trajectory[i].time - trajectory[i - 1].time;
    const bool gap = TooSlow(seconds, options) && LongEnough(way, usual_speed, options);
    if (gap || TooFast(way, seconds, usual_speed, options)) return trajectory[i - 1].time;
  }
  return std::nullopt;
}

}  // namespace turnscale
