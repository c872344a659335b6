// SPDX-License-Identifier: MIT
#include "turnscale/rescale/camera_mount.h"

#include <utility>

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

std::vector<Trajectory> CutAtGaps(const Trajectory& trajectory, const std::vector<int>& gaps) {
  std::vector<Trajectory> pieces(1);
  auto gap = gaps.begin();
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (gap != gaps.end() && *gap == static_cast<int>(i)) {
      pieces.emplace_back();
      ++gap;
    }
    pieces.back().push_back(trajectory[i]);
  }
  return pieces;
}

Eigen::Quaterniond Upright(const std::vector<CameraStep>& steps) {
  Eigen::Vector3d forward = Eigen::Vector3d::Zero();
  for (const CameraStep& step : steps) forward += step.frames * step.previous_from_current.translation;
  return RotationFromForwardAndDown(forward, Eigen::Vector3d::UnitY());
}

}  // namespace

MountFromPath FindCameraMount(const Trajectory& trajectory, bool timed, const std::vector<int>& gaps) {
  std::vector<Trajectory> pieces = CutAtGaps(timed ? trajectory : AtUsualRate(trajectory), gaps);
  const AxisConvention axes = FindAxisConvention(StepsAlong(pieces));
  for (Trajectory& piece : pieces) piece = InCameraAxes(std::move(piece), axes);
  const Eigen::Quaterniond body_from_camera = InCameraAxes({StampedPose{}}, axes).front().world_from_camera.rotation;
  const std::vector<CameraStep> steps = StepsAlong(pieces);
  const Calibration calibration = Calibrate(steps);
  const Eigen::Quaterniond found = calibration.observable ? calibration.vehicle_from_camera : Upright(steps);
  return {found * body_from_camera.conjugate(), calibration.observable};
}

}  // namespace turnscale
