// SPDX-License-Identifier: MIT
#include "turnscale/odometry/mount_calibration.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Half a per cent of scale or so. Roll is known worst, and changes a turn's angle by its cosine only.
constexpr double kLeastChange = 0.05 / kDegreesPerRadian;
constexpr double kLeastRollChange = 5 / kDegreesPerRadian;

bool AreClose(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Vector3d change = VectorFromRotation(a * b.conjugate());
  return change.head<2>().norm() < kLeastChange && std::abs(change.z()) < kLeastRollChange;
}

OnlineCalibrationOptions OptionsFor(const Eigen::Quaterniond& assumed) {
  OnlineCalibrationOptions options;
  options.forward = assumed.inverse() * Eigen::Vector3d::UnitZ();
  return options;
}

}  // namespace

MountCalibration::MountCalibration(const VehicleOptions& vehicle)
    : calibrates_(vehicle.calibrate_camera),
      calibration_(OptionsFor(vehicle.vehicle_from_camera)),
      mounts_{{0, vehicle.vehicle_from_camera}} {}

bool MountCalibration::Learn(const Map& map, int last) {
  if (!calibrates_) return false;
  bool changed = false;
  for (; next_keyframe_ <= last; ++next_keyframe_) {
    const Keyframe& keyframe = map.keyframes[next_keyframe_];
    if (keyframe.after_gap) gatherer_.Break();
    const RigidTransform pose = keyframe.camera_from_world.inverse();
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite()) {
      gatherer_.Break();
      continue;
    }
    const std::optional<CameraStep> step = gatherer_.Add({keyframe.time, pose});
    if (!step) continue;
    const OnlineState& state = calibration_.Add(*step);
    step_ends_.push_back(next_keyframe_);
    // What the calibration goes on with comes after the move.
    if (state.moved) {
      mounts_.push_back({step_ends_[step_ends_.size() - state.steps], current().vehicle_from_camera});
    }
    if (!state.usable) continue;
    Mount& mount = mounts_.back();
    mount.found = true;
    mount.sigma = state.sigma;
    if (AreClose(state.vehicle_from_camera, mount.vehicle_from_camera)) continue;
    mount.vehicle_from_camera = state.vehicle_from_camera;
    changed = true;
  }
  return changed;
}

const Eigen::Quaterniond& MountCalibration::At(int keyframe) const {
  const auto later = [](int k, const Mount& mount) { return k < mount.first_keyframe; };
  return std::prev(std::upper_bound(mounts_.begin() + 1, mounts_.end(), keyframe, later))->vehicle_from_camera;
}

}  // namespace turnscale
