// SPDX-License-Identifier: MIT
#include "turnscale/odometry/road_heights.h"

#include <algorithm>
#include <cmath>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/step_height.h"

namespace turnscale {
namespace {

// Change of ln(ratio) beyond which the derivatives no longer hold.
constexpr double kMostChange = 0.1;

// Of ln(ratio) since it was measured.
double ChangeOf(const MeasuredHeight& height, const RigidTransform& motion) {
  const RigidTransform& then = height.reference_from_keyframe;
  const Eigen::Vector3d rotation = VectorFromRotation(motion.rotation * then.rotation.conjugate());
  const Eigen::Vector3d direction = motion.translation.normalized() - then.translation.normalized();
  return height.by_rotation.dot(rotation) + height.by_direction.dot(direction);
}

}  // namespace

void SetStepHeight(const Map& map, const std::vector<MeasuredHeight>& heights, VehicleStep& step) {
  if (step.after_gap || !step.usable) return;
  StepHeight mean;
  for (auto height = std::ranges::upper_bound(heights, step.first, {}, &MeasuredHeight::keyframe);
       height != heights.end() && height->keyframe <= step.last; ++height) {
    const RigidTransform motion = map.keyframes[height->reference].camera_from_world *
                                  map.keyframes[height->keyframe].camera_from_world.inverse();
    const double distance = motion.translation.norm();
    if (!(distance > 0) || !std::isfinite(distance)) continue;
    const double change = ChangeOf(*height, motion);
    if (std::abs(change) <= kMostChange) mean.Add(height->ratio * std::exp(change) * distance, height->sigma);
  }
  mean.SetOn(step);
}

}  // namespace turnscale
