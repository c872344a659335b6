// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_trials.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/laboratory/scale_drive.h"
#include "turnscale/mapping/absolute_scale_recovery.h"
#include "turnscale/odometry/constrained_turns.h"
#include "turnscale/odometry/drive_scale.h"

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

// What errors of a run are drawn from; other numbers than those of the drive's points and pixels.
constexpr std::uint64_t kStreamOfErrors = 0x9e3779b97f4a7c15;

CarErrors DrawErrors(const CarErrors& sigmas, std::uint64_t seed) {
  Random random(seed ^ kStreamOfErrors);
  return {sigmas.lever_arm * random.Gaussian(), sigmas.side_slip * random.Gaussian(), sigmas.yaw * random.Gaussian()};
}

ScaleEstimatorSettings Told(ScaleEstimatorSettings settings, const CarErrors& errors) {
  VehicleOptions& vehicle = settings.odometry.vehicle;
  if (vehicle.lever_arm) *vehicle.lever_arm += errors.lever_arm;
  vehicle.side_slip = std::max(0.0, vehicle.side_slip + errors.side_slip);
  vehicle.vehicle_from_camera = RotationFromYawPitchRoll({errors.yaw, 0, 0}) * vehicle.vehicle_from_camera;
  return settings;
}

double PathLength(const Map& map) {
  double length = 0;
  for (std::size_t k = 1; k < map.keyframes.size(); ++k)
    length += (Centre(map.keyframes[k]) - Centre(map.keyframes[k - 1])).norm();
  return length;
}

ScaleTrial RunOnce(const ScaleTrials& trials, int run) {
  ScaleDriveOptions options = trials.drive;
  options.seed = SeedOfRun(trials.seed, run);
  const ScaleDrive drive = MakeScaleDrive(options);
  const Eigen::Quaterniond& mount = options.drive.vehicle_from_camera;
  Map map = PointOdometry(drive);
  LoseScale(options.scale_loss, options.scale_loss_frames, map);
  const double turning = kTurningAngle;
  ScaleTrial trial;
  trial.odometry = MeasureScale(drive, drive.odometry, mount, turning);
  trial.adjusted = MeasureScale(drive, KeyframePoses(map), mount, turning);
  const double true_length = PathLength(drive.truth);
  const CarErrors errors = DrawErrors(trials.told_wrong, options.seed);
  for (const ScaleEstimatorSettings& estimator : trials.estimators) {
    const RecoveredScale recovered = RecoverScale(Told(estimator, errors), options.pixel_noise, map);
    trial.recovered.push_back(MeasureScale(drive, KeyframePoses(recovered.map), mount, turning));
    trial.converged.push_back(recovered.converged ? 1 : 0);
    trial.length.push_back({std::log(PathLength(recovered.map) / true_length), recovered.length_sigma});
    trial.side_slip.emplace_back();
    if (recovered.car && recovered.car->side_slip_sigma > 0)
      trial.side_slip.back() = {recovered.car->side_slip - estimator.odometry.vehicle.side_slip,
                                recovered.car->side_slip_sigma};
  }
  return trial;
}

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
  std::vector<TurnScale> turns = TurnsToConstrain(map, scale.mount(), options, refined.turns);
  if (settings.weighs_turns) {
    for (TurnScale& held : turns)
      for (const TurnResult& turn : refined.turns)
        if (turn.first_keyframe + 1 == held.first_step) held.sigma = turn.own_sigma / turn.own;
  }
  if (!turns.empty()) {
    const ScaleRecoveryResult recovered = RecoverAbsoluteScale(options.scale.recovery, turns, map);
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

std::vector<ScaleTrial> RunScaleTrials(const ScaleTrials& trials) {
  std::vector<ScaleTrial> results(trials.runs);
  const bool finished = ParallelRuns(
      trials.runs, trials.jobs, [&](int run) { results[run] = RunOnce(trials, run); }, trials.progress);
  return finished ? results : std::vector<ScaleTrial>();
}

MeanAndSpread MeanAndSpreadOf(const std::vector<double>& values) {
  MeanAndSpread result;
  const auto count = static_cast<double>(values.size());
  for (const double value : values) result.mean += value / count;
  for (const double value : values) result.spread += (value - result.mean) * (value - result.mean);
  result.spread = count > 1 ? std::sqrt(result.spread / (count - 1)) : 0;
  return result;
}

}  // namespace turnscale
