// SPDX-License-Identifier: MIT
#include "turnscale/calibration/step_gatherer.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

bool Finite(const StampedPose& pose) {
  return std::isfinite(pose.time) && pose.world_from_camera.translation.allFinite() &&
         pose.world_from_camera.rotation.coeffs().allFinite();
}

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

double Speed(const StampedPose& a, const StampedPose& b) { return Distance(a, b) / (b.time - a.time); }

// Takes the motion between two frames; gives the step that it completes.
std::optional<CameraStep> Gather(const StampedPose& last, const StampedPose& pose, double usual_speed,
                                 const StepOptions& options, FrameMotions& open) {
  if (open.frames == 0) open.begin = last.time;
  const RigidTransform motion = last.world_from_camera.inverse() * pose.world_from_camera;
  open.rotation += VectorFromRotation(motion.rotation);
  open.translation += motion.translation;
  ++open.frames;
  // A frame falls short of the wanted length by rounding as often as not.
  const bool long_enough = usual_speed > 0 && open.translation.norm() > 0.99 * options.duration * usual_speed;
  const bool too_slow = pose.time - open.begin > options.max_slowness * options.duration;
  if (!long_enough && !too_slow) return std::nullopt;
  const double share = 1.0 / open.frames;
  const CameraStep step{
      {RotationFromVector(share * open.rotation), share * open.translation}, open.frames, open.begin, pose.time};
  open = FrameMotions();
  if (!long_enough) return std::nullopt;
  return step;
}

}  // namespace

void StepOptions::Check() const {
  if (!(duration > 0) || !std::isfinite(duration)) throw InputError("duration: must be above 0 s");
  if (!(max_slowness >= 1)) throw InputError("max_slowness: must be at least 1");
  if (!(usual_speed_quantile > 0 && usual_speed_quantile < 1)) {
    throw InputError("usual_speed_quantile: must lie between 0 and 1");
  }
  if (speed_memory < 1) throw InputError("speed_memory: must be at least 1");
}

StepGatherer::StepGatherer(const StepOptions& options) : options_(options) { options_.Check(); }

std::optional<CameraStep> StepGatherer::Add(const StampedPose& pose) {
  CheckPose(last_, pose);
  std::optional<CameraStep> step;
  if (last_) {
    speeds_.push_back(Speed(*last_, pose));
    if (static_cast<int>(speeds_.size()) > options_.speed_memory) speeds_.pop_front();
    const double usual_speed = Quantile({speeds_.begin(), speeds_.end()}, options_.usual_speed_quantile);
    step = Gather(*last_, pose, usual_speed, options_, open_);
  }
  last_ = pose;
  return step;
}

void StepGatherer::Break() {
  last_.reset();
  open_ = FrameMotions();
}

std::vector<CameraStep> StepsAlong(const Trajectory& trajectory, const StepOptions& options) {
  options.Check();
  std::vector<double> speeds;
  for (size_t i = 0; i < trajectory.size(); ++i) {
    CheckPose(i > 0 ? std::optional(trajectory[i - 1]) : std::nullopt, trajectory[i]);
    if (i > 0) speeds.push_back(Speed(trajectory[i - 1], trajectory[i]));
  }
  const double usual_speed = Quantile(std::move(speeds), options.usual_speed_quantile);
  std::vector<CameraStep> steps;
  FrameMotions open;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    const auto step = Gather(trajectory[i - 1], trajectory[i], usual_speed, options, open);
    if (step) steps.push_back(*step);
  }
  return steps;
}

}  // namespace turnscale
