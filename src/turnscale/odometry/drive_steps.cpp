// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_steps.h"

#include <algorithm>
#include <cmath>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {
namespace {

constexpr double kAnyLeverArm = 1;

// How well the landmarks determine the unit of length along a step.
void SetUnitVariance(const Map& map, const DriftOptions& drift, VehicleStep& step) {
  if (step.after_gap) return;
  // With a standard deviation of 1 of its logarithm, the unit is unknown.
  constexpr double kMostVariance = 1;
  double variance = 0;
  for (int k = step.first + 1; k <= step.last; ++k)
    variance += std::min(map.keyframes[k].pixel_unit_variance, kMostVariance);
  step.unit_variance = std::min(drift.unit_inflation * drift.unit_inflation * variance, kMostVariance);
}

// Of the height as the images show it, instead of as measured. The covariances stay.
void WidenHeight(double aspect_sigma, CarPrior& car) {
  if (aspect_sigma == 0) return;
  const double before = car.camera_height_sigma;
  car.camera_height_sigma = std::hypot(before, aspect_sigma * car.camera_height);
  car.height_correlation *= before / car.camera_height_sigma;
  car.height_slip_correlation *= before / car.camera_height_sigma;
}

}  // namespace

bool HasMetres(const VehicleOptions& vehicle) { return vehicle.lever_arm || vehicle.camera_height; }

double YawSigma(const VehicleOptions& vehicle, const Mount& mount) {
  if (!vehicle.calibrate_camera) return vehicle.yaw_sigma;
  if (mount.found) return PriorYawSigma(mount.sigma.yaw, vehicle.yaw_sigma);
  const bool as_given = vehicle.camera_known && mount.first_keyframe == 0;
  return as_given ? vehicle.yaw_sigma : std::max(vehicle.yaw_sigma, kYawSigmaByEye);
}

CarPrior PriorOf(const VehicleOptions& vehicle, const Mount& mount, double aspect_sigma) {
  CarPrior car;
  car.lever_arm = vehicle.lever_arm.value_or(vehicle.camera_height ? 0.0 : kAnyLeverArm);
  car.lever_arm_sigma = vehicle.lever_arm ? vehicle.LeverArmSigma() : TapeSigma(car.lever_arm);
  if (vehicle.camera_height) {
    car.camera_height = *vehicle.camera_height;
    car.camera_height_sigma = vehicle.HeightSigma();
    car.height_correlation = vehicle.height_correlation;
    car.height_slip_correlation = vehicle.height_slip_correlation;
  }
  if (vehicle.has_measured_height()) WidenHeight(aspect_sigma, car);
  car.side_slip = vehicle.side_slip;
  car.side_slip_sigma = vehicle.side_slip_sigma;
  if (vehicle.lever_arm) car.lever_arm_slip_correlation = vehicle.lever_arm_slip_correlation;
  car.yaw_sigma = YawSigma(vehicle, mount);
  car.roll_height = vehicle.roll_height;
  car.roll_height_sigma = vehicle.roll_height_sigma;
  car.image_lag = vehicle.image_lag;
  car.image_lag_sigma = vehicle.image_lag_sigma;
  return car;
}

Eigen::Vector3d KnownCentre(const Map& map, int keyframe) {
  while (keyframe > 0 && !Centre(map.keyframes[keyframe]).allFinite()) --keyframe;
  return Centre(map.keyframes[keyframe]);
}

StampedPose VehiclePose(const Map& map, const MountCalibration& mount, int keyframe) {
  const RigidTransform pose = map.keyframes[keyframe].camera_from_world.inverse();
  return {map.keyframes[keyframe].time, {pose.rotation * mount.At(keyframe).conjugate(), pose.translation}};
}

std::optional<PathGap> GapBefore(const Map& map, int keyframe) {
  if (keyframe == 0 || !map.keyframes[keyframe].after_gap) return std::nullopt;
  return PathGap{keyframe, map.keyframes[keyframe].gap_sigma};
}

void CompleteStep(const Map& map, const std::vector<MeasuredHeight>& heights, const DriftOptions& drift,
                  VehicleStep& step) {
  SetStepHeight(map, heights, step);
  SetUnitVariance(map, drift, step);
}

std::vector<VehicleStep> StepsAlong(const Map& map, const MountCalibration& mount,
                                    const std::vector<MeasuredHeight>& heights, const OdometryOptions& options) {
  Trajectory path;
  std::vector<PathGap> gaps;
  for (int k = 0; k < CountKeyframes(map); ++k) {
    path.push_back(VehiclePose(map, mount, k));
    if (const auto gap = GapBefore(map, k)) gaps.push_back(*gap);
  }
  std::vector<VehicleStep> steps = CutIntoSteps(path, gaps, true, options.steps);
  for (VehicleStep& step : steps) CompleteStep(map, heights, options.scale.estimator.drift, step);
  return steps;
}

TurningMotion StepMotion(const Map& map, int keyframe, const MountCalibration& mount) {
  const RigidTransform& previous = map.keyframes[keyframe].camera_from_world;
  const RigidTransform& current = map.keyframes[keyframe + 1].camera_from_world;
  RigidTransform previous_from_current = previous * current.inverse();
  const Eigen::Quaterniond before = mount.At(keyframe);
  const Eigen::Quaterniond after = mount.At(keyframe + 1);
  if (before.coeffs() == after.coeffs()) return TurningMotionOf(previous_from_current, after);
  previous_from_current.rotation = previous_from_current.rotation * (after.conjugate() * before);
  return TurningMotionOf(previous_from_current, before);
}

}  // namespace turnscale
