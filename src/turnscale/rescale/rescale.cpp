// SPDX-License-Identifier: MIT
#include "turnscale/rescale/rescale.h"

#include <algorithm>
#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/rescale/camera_mount.h"

namespace turnscale {
namespace {

void CheckTrajectory(const Trajectory& trajectory, bool timed, const std::vector<int>& gaps) {
  if (trajectory.size() < 2) throw InputError("the trajectory has fewer than two poses");
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const RigidTransform& pose = trajectory[i].world_from_camera;
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite()) {
      throw InputError("pose " + std::to_string(i) + " is not finite");
    }
    if (timed && i > 0 && !(trajectory[i].time > trajectory[i - 1].time)) {
      throw InputError("the time of pose " + std::to_string(i) + " does not come after the one before");
    }
  }
  int last = 0;
  for (const int gap : gaps) {
    if (gap <= last || gap >= static_cast<int>(trajectory.size())) {
      throw InputError("gaps: " + std::to_string(gap) + " is no pose after the first, or out of order");
    }
    last = gap;
  }
}

CarPrior CarFor(const RescaleOptions& options) {
  CarPrior car = options.car;
  if (!options.timed) car.side_slip = car.side_slip_sigma = 0;
  return car;
}

// What the drive says of the car.
void DescribeCar(const ScaleEstimate& estimate, const RescaleOptions& options, RescaleResult& result) {
  const Belief& last = estimate.smoothed.back();
  const auto sigma = [&](DriveUnknown unknown) { return std::sqrt(last.covariance(unknown, unknown)); };
  result.yaw_error = -last.mean[kTravel];
  result.yaw_error_sigma = sigma(kTravel);
  result.side_slip = std::max(last.mean[kSlip], 0.0);
  result.side_slip_sigma = options.timed && options.car.side_slip_sigma > 0 ? sigma(kSlip) : 0;
  result.side_slip_at_bound = estimate.side_slip_at_bound;
  result.height = last.mean[kHeight];
  result.height_sigma = sigma(kHeight);
  result.noise = estimate.noise;
  result.sway_sigma = estimate.sway_sigma * std::exp(last.mean[kLogScale]);
  result.converged = estimate.converged;
}

// Steps, each at the mean of its ends' scales, put together again.
Trajectory MetricTrajectory(const Trajectory& trajectory, const std::vector<PoseScale>& scales) {
  Trajectory metric = trajectory;
  metric[0].world_from_camera.translation *= scales[0].metres_per_unit;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const Eigen::Vector3d step =
        trajectory[i].world_from_camera.translation - trajectory[i - 1].world_from_camera.translation;
    const double scale = 0.5 * (scales[i - 1].metres_per_unit + scales[i].metres_per_unit);
    metric[i].world_from_camera.translation = metric[i - 1].world_from_camera.translation + scale * step;
  }
  return metric;
}

double BestSigma(const std::vector<PoseScale>& poses) {
  return std::min_element(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.sigma < b.sigma; })
      ->sigma;
}

std::string Rounded(double value) { return std::to_string(std::lround(value)); }

std::string WhatWouldDo(const RescaleOptions& options) {
  return "give a drive with a slow turn of " + Rounded(options.stretches.turns.min_region_angle * kDegreesPerRadian) +
         " degrees or more";
}

// Leaves the reason why there is none.
bool FindMount(const RescaleOptions& options, const Trajectory& trajectory, const std::vector<int>& gaps,
               RescaleResult& result) {
  try {
    result.vehicle_from_camera =
        options.vehicle_from_camera ? *options.vehicle_from_camera : FindCameraMount(trajectory, options.timed, gaps);
    return true;
  } catch (const InputError& error) {
    result.reason = error.what();
    return false;
  }
}

bool GoesForward(const std::vector<SwayStep>& steps) {
  const auto forward = std::count_if(steps.begin(), steps.end(), [](const SwayStep& step) { return step.forward; });
  return 2 * forward >= static_cast<std::ptrdiff_t>(steps.size());
}

}  // namespace

void RescaleOptions::Check() const {
  car.Check();
  keys.Check();
  stretches.Check();
  estimator.Check();
  if (!(lever_arm_sigma >= 0 && lever_arm_sigma < 1)) throw InputError("lever_arm_sigma: has to be from 0 to below 1");
  if (!(max_scale_sigma > 0)) throw InputError("max_scale_sigma: has to be positive");
}

RescaleResult RescaleTrajectory(const RescaleOptions& options, const Trajectory& trajectory,
                                const std::vector<int>& gaps) {
  options.Check();
  CheckTrajectory(trajectory, options.timed, gaps);
  RescaleResult result;
  if (!FindMount(options, trajectory, gaps, result)) return result;
  result.key_spacing = KeySpacing(trajectory, result.vehicle_from_camera, options.keys);
  const std::vector<SwayStep> steps =
      SwaySteps(trajectory, result.vehicle_from_camera, result.key_spacing, options.timed, options.keys, gaps);
  if (!GoesForward(steps)) {
    result.reason =
        "most of its steps go sideways, up, down or backwards for a camera turned like that; let its rotation be found";
    return result;
  }
  const std::vector<Stretch> stretches = SplitIntoStretches(steps, options.stretches);
  if (std::none_of(stretches.begin(), stretches.end(), [](const Stretch& stretch) { return stretch.turning; })) {
    result.reason = "it has no turn; " + WhatWouldDo(options);
    return result;
  }
  const auto estimate = EstimateScale(steps, stretches, CarFor(options), options.estimator);
  if (!estimate) {
    result.reason =
        "in no turn slow enough the camera swings outwards as its lever arm demands; " + WhatWouldDo(options);
    return result;
  }
  const double common_sigma = options.lever_arm_sigma;
  result.turns = DescribeTurns(steps, stretches, *estimate, common_sigma);
  DescribeCar(*estimate, options, result);
  result.poses = ScalePoses(static_cast<int>(trajectory.size()), steps, stretches, *estimate, common_sigma);
  if (const double sigma = BestSigma(result.poses); !(sigma <= options.max_scale_sigma)) {
    result.poses.clear();
    result.reason = "its turns leave the scale uncertain by " + Rounded(100 * sigma) + " %, more than " +
                    Rounded(100 * options.max_scale_sigma) + "; " + WhatWouldDo(options);
    return result;
  }
  result.metric = MetricTrajectory(trajectory, result.poses);
  for (const SwayStep& step : steps) {
    if (step.usable) result.length += step.length * result.poses[step.last].metres_per_unit;
  }
  result.observable = true;
  return result;
}

}  // namespace turnscale
