// SPDX-License-Identifier: MIT
#include "turnscale/rescale/camera_mount.h"

#include "turnscale/calibration/axis_convention.h"
#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/camera_angles.h"
#include "turnscale/calibration/step_gatherer.h"

namespace turnscale {
namespace {

// The calibration's steps are as long as the car drives in a certain time.
Trajectory AtUsualRate(Trajectory trajectory) {
  constexpr double kInterval = 0.1;
  for (std::size_t i = 0; i < trajectory.size(); ++i) trajectory[i].time = kInterval * static_cast<double>(i);
  return trajectory;
}

Eigen::Quaterniond Upright(const std::vector<CameraStep>& steps) {
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
  for (const CameraStep& step : steps) forward += step.frames * step.previous_from_current.translation;
  return RotationFromForwardAndDown(forward, Eigen::Vector3d::UnitY());
}

}  // namespace

Eigen::Quaterniond FindCameraMount(const Trajectory& trajectory, bool timed) {
  const Trajectory path = timed ? trajectory : AtUsualRate(trajectory);
  std::vector<CameraStep> steps = StepsAlong(path);
  Eigen::Quaterniond camera_from_body = Eigen::Quaterniond::Identity();
  if (FindAxisConvention(steps) == AxisConvention::kVehicle) {
    steps = StepsAlong(InCameraAxes(path));
    camera_from_body = InCameraAxes({StampedPose{}}).front().world_from_camera.rotation.conjugate();
  }
  const Calibration calibration = Calibrate(steps);
  return (calibration.observable ? calibration.vehicle_from_camera : Upright(steps)) * camera_from_body;
}

}  // namespace turnscale
