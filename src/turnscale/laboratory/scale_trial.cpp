// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_trial.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/kinematics/pooled_scale.h"
#include "turnscale/kinematics/turning_motion.h"
#include "turnscale/odometry/drive_scale.h"
#include "turnscale/odometry/turn_reading.h"
#include "turnscale/scale/absolute_scale_recovery.h"

namespace turnscale {
namespace {

std::vector<TurningRegion> DetectTurns(const TurnDetectorOptions& options, const MountCalibration& mount,
                                       const Map& map) {
  TurnDetector detector(options);
  std::vector<TurningRegion> regions;
  const auto keep = [&](const std::optional<TurningRegion>& region) {
    if (region) regions.push_back(*region);
  };
  for (int step = 0; step + 1 < static_cast<int>(map.keyframes.size()); ++step)
    keep(detector.Add(StepMotion(map, step, mount).psi));
  keep(detector.Finish());
  return regions;
}

double SquaredError(double estimate, double truth) { return (estimate - truth) * (estimate - truth); }

}  // namespace

OdometryOptions SyntheticDriveOdometry() {
  OdometryOptions options;
  options.vehicle.lever_arm = PaperDriveOptions().lever_arm;
  options.vehicle.side_slip = 0;
  options.vehicle.side_slip_sigma = 0;
  options.vehicle.calibrate_camera = false;
  options.turns.min_step_angle = kTurningAngle;
  options.scale.recovery.pixel_sigma_inflation = 1;
  return options;
}

RecoveredScale RecoverScale(const ScaleEstimatorSettings& settings, double pixel_noise, Map map) {
  const OdometryOptions& options = settings.odometry;
  if (!options.vehicle.lever_arm) throw InputError("lever_arm: has to be given");
  const MountCalibration mount(options.vehicle);
  const LeverArm lever_arm{*options.vehicle.lever_arm, options.vehicle.side_slip};
  const bool per_frame = options.pooled_scale.method == ScaleMethod::kPerFrame;
  RecoveredScale result;
  std::vector<TurnScale> turns;
  for (const TurningRegion& region : DetectTurns(options.turns, mount, map)) {
    if (settings.most_turns && std::cmp_greater_equal(turns.size(), *settings.most_turns)) break;
    const std::vector<TurningStep> steps = StepsOfTurn(map, region, mount);
    const PooledScaleResult pooled = PoolScale(steps, lever_arm, options.pooled_scale);
    if (!pooled.scale) continue;
    result.regions.push_back(region);
    turns.push_back(HeldTurn(region, pooled.scale->metres_per_unit));
    if (settings.weighs_turns || options.Smooths())
      turns.back().sigma = pooled.scale->sigma / pooled.scale->metres_per_unit;
    if (per_frame) HoldEachStep(steps, lever_arm, turns.back());
  }
  if (!turns.empty()) {
    if (options.Smooths()) {
      const std::vector<double> units(map.keyframes.size(), 1.0);
      if (const std::optional<DriveScale> drive = DriveScaleOf(map, units, mount, options))
        for (TurnScale& turn : turns) WeighSmoothed(drive->keyframes, map, units, turn);
    }
    ScaleRecoveryOptions recovery = options.scale.recovery;
    recovery.pixel_sigma = pixel_noise;
    const ScaleRecoveryResult recovered = RecoverAbsoluteScale(recovery, turns, 0, map);
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
