// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_trials.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "turnscale/base/random.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/laboratory/point_odometry.h"

namespace turnscale {
namespace {

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
