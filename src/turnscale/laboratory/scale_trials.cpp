// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_trials.h"

#include <cmath>
#include <cstddef>

#include "turnscale/laboratory/point_odometry.h"

namespace turnscale {
namespace {

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
  for (const ScaleEstimatorSettings& estimator : trials.estimators) {
    const RecoveredScale recovered = RecoverScale(estimator, options.pixel_noise, map);
    trial.recovered.push_back(MeasureScale(drive, KeyframePoses(recovered.map), mount, turning));
    trial.converged.push_back(recovered.converged ? 1 : 0);
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
