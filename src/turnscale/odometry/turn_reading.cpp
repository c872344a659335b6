// SPDX-License-Identifier: MIT
#include "turnscale/odometry/turn_reading.h"

#include <cmath>

#include "turnscale/kinematics/scale_observer.h"

namespace turnscale {

TurningMotion StepMotion(const Map& map, int step, const MountCalibration& mount) {
  const RigidTransform& previous = map.keyframes[step].camera_from_world;
  const RigidTransform& current = map.keyframes[step + 1].camera_from_world;
  return TurningMotionOf(previous * current.inverse(), mount.At(step + 1));
}

std::vector<TurningStep> StepsOfTurn(const Map& map, const TurningRegion& region, const MountCalibration& mount) {
  std::vector<TurningStep> steps;
  for (int step = region.first; step <= region.last; ++step)
    steps.push_back({StepMotion(map, step, mount), map.keyframes[step + 1].time - map.keyframes[step].time});
  return steps;
}

// Step k of a region leads to keyframe k + 1, which is how the recovery counts.
TurnScale HeldTurn(const TurningRegion& region, double factor) {
  return {region.first + 1, region.last + 1, factor, {}, 0};
}

void HoldEachStep(const std::vector<TurningStep>& steps, const LeverArm& lever_arm, TurnScale& turn) {
  for (const TurningStep& step : steps) {
    const double distance = step.dt > 0 ? ObservedDistance(step.motion.psi, step.motion.theta, step.dt, lever_arm)
                                        : ObservedDistance(step.motion.psi, step.motion.theta, lever_arm.length);
    turn.distances.push_back(std::isfinite(distance) && distance > 0 ? distance : 0.0);
  }
}

bool WeighSmoothed(const std::vector<PoseScale>& scales, const Map& map, const std::vector<double>& unit_at_keyframe,
                   TurnScale& turn) {
  if (scales.size() != map.keyframes.size()) return false;
  double metres = 0;
  double length = 0;
  for (int k = turn.first_step; k <= turn.last_step; ++k) {
    const double step = (Centre(map.keyframes[k]) - Centre(map.keyframes[k - 1])).norm();
    length += step;
    metres += step / unit_at_keyframe[k] * scales[k].metres_per_unit;
  }
  const double factor = metres / length;
  const double sigma = scales[turn.last_step].own_sigma;
  if (!std::isfinite(factor) || factor <= 0 || !std::isfinite(sigma) || sigma <= 0) return false;
  turn.factor = factor;
  turn.sigma = sigma;
  turn.distances.clear();
  return true;
}

}  // namespace turnscale
