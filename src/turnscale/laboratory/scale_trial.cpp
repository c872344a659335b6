// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_trial.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/kinematics/turning_motion.h"
#include "turnscale/mapping/absolute_scale_recovery.h"
#include "turnscale/odometry/drive_scale.h"
#include "turnscale/odometry/held_turns.h"

namespace turnscale {
namespace {

// Of all turns or the first `most`.
void KeepFirst(std::optional<int> most, std::vector<TurnResult>& turns) {
  int used = 0;
  for (TurnResult& turn : turns)
    if (turn.used && most && ++used > *most) turn.used = false;
}

// The map with its shape as it is, brought to metres by the scale along it.
Map MetricMap(const RefinedScale& refined, Map map) {
  SetKeyframeCentres(refined.path.centres, map);
  return map;
}

double SquaredError(double estimate, double truth) { return (estimate - truth) * (estimate - truth); }

}  // namespace

OdometryOptions SyntheticDriveOdometry() {
  OdometryOptions options;
  options.vehicle.lever_arm = PaperDriveOptions().lever_arm;
  options.vehicle.side_slip = 0;
  options.vehicle.side_slip_sigma = 0;
  options.vehicle.calibrate_camera = false;
  options.scale.estimator.segments.turns = {.min_step_angle = kTurningAngle};
  // Each keyframe step is a step of the estimator, as in the paper.
  options.steps.angle = 0;
  options.vehicle.lever_arm_sigma = 0;
  // The drive's odometry loses its unit several times faster than a real one drifts.
  options.scale.estimator.drift.per_100m = 0.1;
  options.scale.recovery.pixel_sigma_inflation = 1;
  return options;
}

RecoveredScale RecoverScale(const ScaleEstimatorSettings& settings, double pixel_noise, Map map) {
  OdometryOptions options = settings.odometry;
  if (!options.vehicle.lever_arm) throw InputError("lever_arm: has to be given");
  options.scale.recovery.pixel_sigma = pixel_noise;
  DriveScale scale(options);
  RefinedScale refined = scale.Refine(map);
  RecoveredScale result;
  if (refined.estimate) {
    result.length_sigma = refined.estimate->length_sigma;
    result.car = refined.estimate->car;
  }
  KeepFirst(settings.most_turns, refined.turns);
  for (const TurnResult& turn : refined.turns)
    if (turn.used) result.regions.push_back({turn.first_keyframe, turn.last_keyframe - 1, turn.angle});
  if (options.scale.method == ScaleMethod::kSmoothed && !settings.weighs_turns) {
    result.converged = refined.estimate && refined.estimate->converged;
    result.map = MetricMap(refined, std::move(map));
    return result;
  }
  std::vector<TurnScale> turns = TurnsToHold(map, scale.mount(), options, refined.turns);
  if (settings.weighs_turns) {
    for (TurnScale& held : turns)
      for (const TurnResult& turn : refined.turns)
        if (turn.first_keyframe + 1 == held.first_step) held.sigma = turn.sigma / turn.metres_per_unit;
  }
  if (!turns.empty()) {
    const ScaleRecoveryResult recovered = RecoverAbsoluteScale(options.scale.recovery, turns, 0, map);
    result.converged = std::ranges::all_of(
        recovered.ranges, [](const RangeRecovery& range) { return range.adjusted && range.summary.converged; });
  }
  result.map = std::move(map);
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
