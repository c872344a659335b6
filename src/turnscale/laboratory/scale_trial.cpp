// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_trial.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "turnscale/kinematics/scale_observer.h"
#include "turnscale/kinematics/turning_motion.h"
#include "turnscale/laboratory/turn_scale_smoother.h"

namespace turnscale {
namespace {

TurningMotion MotionOf(const Map& map, int step, const Eigen::Quaterniond& vehicle_from_camera) {
  const RigidTransform& previous = map.keyframes[step].camera_from_world;
  const RigidTransform& current = map.keyframes[step + 1].camera_from_world;
  return TurningMotionOf(previous * current.inverse(), vehicle_from_camera);
}

std::vector<TurningRegion> DetectTurns(const ScaleEstimatorSettings& settings, const Map& map) {
  TurnDetector detector(settings.turns);
  std::vector<TurningRegion> regions;
  const auto keep = [&](const std::optional<TurningRegion>& region) {
    if (region) regions.push_back(*region);
  };
  for (int step = 0; step + 1 < static_cast<int>(map.keyframes.size()); ++step)
    keep(detector.Add(MotionOf(map, step, settings.vehicle_from_camera).psi));
  keep(detector.Finish());
  return regions;
}

// The lengths (metres) of a turn's steps: the turn's scale times what the odometry has, or in the paper's form what
// each step's own angles say (22).
TurnScale HeldTurn(const ScaleEstimatorSettings& settings, const ObservedTurn& observed,
                   const std::vector<TurningStep>& steps, const std::vector<Eigen::Vector3d>& centres) {
  // Step k of a region leads to keyframe k + 1, which is how the recovery counts.
  TurnScale turn{observed.region.first + 1, observed.region.last + 1, 1, {}};
  double metres = 0;
  double units = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const TurningMotion& motion = steps[i].motion;
    const int k = turn.first_step + static_cast<int>(i);
    metres += observed.metres_per_unit * motion.step;
    units += (centres[k] - centres[k - 1]).norm();
    const double own = ObservedDistance(motion.psi, motion.theta, steps[i].dt, settings.lever_arm);
    turn.distances.push_back(settings.pooled.method == ScaleMethod::kPooledLine ? observed.metres_per_unit * motion.step
                             : std::isfinite(own) && own > 0                    ? own
                                                                                : 0);
  }
  turn.factor = metres / units;
  return turn;
}

double SquaredError(double estimate, double truth) { return (estimate - truth) * (estimate - truth); }

}  // namespace

RecoveredScale RecoverScale(const ScaleEstimatorSettings& settings, double pixel_noise, const Map& adjusted,
                            Map drifted) {
  RecoveredScale result;
  Map& map = result.map = std::move(drifted);
  std::vector<ObservedTurn> observed;
  std::vector<std::vector<TurningStep>> turn_steps;
  for (const TurningRegion& region : DetectTurns(settings, adjusted)) {
    if (settings.most_turns && std::cmp_greater_equal(observed.size(), *settings.most_turns)) break;
    std::vector<TurningStep> steps;
    for (int step = region.first; step <= region.last; ++step)
      steps.push_back({MotionOf(adjusted, step, settings.vehicle_from_camera),
                       adjusted.keyframes[step + 1].time - adjusted.keyframes[step].time});
    const PooledScaleResult pooled = PoolScale(steps, settings.lever_arm, settings.pooled);
    if (!pooled.scale) continue;
    observed.push_back({region, pooled.scale->metres_per_unit, pooled.scale->sigma / pooled.scale->metres_per_unit});
    turn_steps.push_back(steps);
    result.regions.push_back(region);
  }
  result.found = !observed.empty();
  if (result.found) {
    if (settings.scales == TurnScales::kSmoothed)
      SmoothTurnScales(KeyframeCentres(adjusted), settings.drift_per_root_metre, observed);
    const std::vector<Eigen::Vector3d> centres = KeyframeCentres(map);
    std::vector<TurnScale> turns;
    for (std::size_t i = 0; i < observed.size(); ++i)
      turns.push_back(HeldTurn(settings, observed[i], turn_steps[i], centres));
    ScaleRecoveryOptions recovery = settings.recovery;
    recovery.pixel_sigma = pixel_noise;
    const ScaleRecoveryResult recovered = RecoverAbsoluteScale(recovery, turns, 0, map);
    result.adjusted = std::ranges::all_of(recovered.ranges, &RangeRecovery::adjusted);
  }
  return result;
}

ScaleErrors MeasureScale(const ScaleDrive& drive, const std::vector<RigidTransform>& world_from_camera,
                         const Eigen::Quaterniond& vehicle_from_camera, double turning_angle) {
  ScaleErrors errors;
  int steps = 0;
  int turning_steps = 0;
  for (std::size_t i = 1; i < drive.stations.size(); ++i) {
    const int a = drive.stations[i - 1];
    const int b = drive.stations[i];
    const RigidTransform motion =
        drive.truth.keyframes[a].camera_from_world * drive.truth.keyframes[b].camera_from_world.inverse();
    const TurningMotion truth = TurningMotionOf(motion, vehicle_from_camera);
    const TurningMotion estimate =
        TurningMotionOf(world_from_camera[a].inverse() * world_from_camera[b], vehicle_from_camera);
    const double ratio = estimate.step / truth.step;
    ++steps;
    errors.psi += SquaredError(estimate.psi, truth.psi);
    errors.theta += SquaredError(estimate.theta, truth.theta);
    errors.scale += SquaredError(estimate.step, truth.step);
    errors.ratio += SquaredError(ratio, 1);
    if (std::abs(truth.psi) < turning_angle) continue;
    ++turning_steps;
    errors.turn_scale += SquaredError(estimate.step, truth.step);
    errors.turn_ratio += SquaredError(ratio, 1);
  }
  const auto root = [](double& sum, int count) { sum = count > 0 ? std::sqrt(sum / count) : 0; };
  for (double* sum : {&errors.psi, &errors.theta, &errors.scale, &errors.ratio}) root(*sum, steps);
  for (double* sum : {&errors.turn_scale, &errors.turn_ratio}) root(*sum, turning_steps);
  return errors;
}

std::vector<RigidTransform> KeyframePoses(const Map& map) {
  std::vector<RigidTransform> poses;
  for (const Keyframe& keyframe : map.keyframes) poses.push_back(keyframe.camera_from_world.inverse());
  return poses;
}

}  // namespace turnscale
