// SPDX-License-Identifier: MIT
#include "turnscale/odometry/mount_calibration.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Half a per cent of scale or so. Roll is known worst, and changes a turn's angle by its cosine only.
constexpr double kLeastChange = 0.05 / kDegreesPerRadian;
constexpr double kLeastRollChange = 5 / kDegreesPerRadian;

// Between an angle that was known and the drive's, in standard deviations, beyond which they contradict each other.
constexpr double kMostKnownDeviation = 3;

// Averages the drive's angle with the one that was known. False, and nothing changed, where they contradict each other.
bool Average(double known, double known_sigma, double& angle, double& sigma) {
  const double difference = std::remainder(known - angle, 2 * M_PI);
  if (std::abs(difference) > kMostKnownDeviation * std::hypot(known_sigma, sigma)) return false;
  const double of_known = 1 / (known_sigma * known_sigma);
  const double of_drive = 1 / (sigma * sigma);
  angle += of_known / (of_known + of_drive) * difference;
  sigma = 1 / std::sqrt(of_known + of_drive);
  return true;
}

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

bool LooksAlong(const Eigen::Quaterniond& vehicle_from_camera) {
  const double tangent_of_most = std::tan(40 / kDegreesPerRadian);
  const Eigen::Vector3d ahead = vehicle_from_camera * Eigen::Vector3d::UnitZ();
  return std::abs(ahead.x()) <= tangent_of_most * std::abs(ahead.z());
}

MountCalibration::MountCalibration(const VehicleOptions& vehicle)
    : calibrates_(vehicle.calibrate_camera),
      known_sigma_{vehicle.yaw_sigma, vehicle.known_pitch_sigma, vehicle.known_roll_sigma},
      calibration_(OptionsFor(vehicle.vehicle_from_camera)),
      mounts_{{0, vehicle.vehicle_from_camera}} {
  if (vehicle.camera_known) known_ = YawPitchRollFromRotation(vehicle.vehicle_from_camera);
}

Mount MountCalibration::Found(const Eigen::Quaterniond& vehicle_from_camera, const YawPitchRoll& sigma) const {
  Mount found = mounts_.back();
  found.vehicle_from_camera = vehicle_from_camera;
  found.found = true;
  found.sigma = sigma;
  // A camera that has been moved is as the drive says.
  if (!known_ || moves() > 0) return found;
  YawPitchRoll angles = YawPitchRollFromRotation(vehicle_from_camera);
  // A contradicted yaw makes pitch and roll doubtful, too.
  if (!Average(known_->yaw, known_sigma_.yaw, angles.yaw, found.sigma.yaw)) return found;
  Average(known_->pitch, known_sigma_.pitch, angles.pitch, found.sigma.pitch);
  Average(known_->roll, known_sigma_.roll, angles.roll, found.sigma.roll);
  found.vehicle_from_camera = RotationFromYawPitchRoll(angles);
  return found;
}

void MountCalibration::EndMount(const OnlineState& state) {
  if (!mounts_.back().found || !std::isfinite(state.sigma_before_move.yaw)) return;
  mounts_.back() = Found(state.vehicle_from_camera_before_move, state.sigma_before_move);
}

void MountCalibration::Learn(const Map& map, int last) {
  if (last >= next_keyframe_) Learn(std::span(map.keyframes).subspan(next_keyframe_, last + 1 - next_keyframe_));
}

void MountCalibration::Learn(std::span<const Keyframe> next) {
  for (const Keyframe& keyframe : next) {
    const int index = next_keyframe_++;
    if (!calibrates_) continue;
    if (keyframe.after_gap) gatherer_.Break();
    RigidTransform pose = keyframe.camera_from_world.inverse();
    if (!pose.IsFinite()) {
      gatherer_.Break();
      continue;
    }
    if (!jumps_.empty()) pose.rotation = pose.rotation * StartFromKeyframe(index).conjugate();
    const std::optional<CameraStep> step = gatherer_.Add({keyframe.time, pose});
    if (!step) continue;
    const OnlineState& state = calibration_.Add(*step);
    step_ends_.push_back(index);
    // What the calibration goes on with comes after the move.
    if (state.moved) {
      EndMount(state);
      mounts_.push_back({.first_keyframe = step_ends_[step_ends_.size() - state.steps],
                         .vehicle_from_camera = mounts_.back().vehicle_from_camera,
                         .move = {state.move_time, state.move}});
    }
    if (!state.usable) continue;
    // What was known is better than a first, rough estimate.
    if (known_ && moves() == 0 && state.sigma.yaw > kEstimatedYawSigma) continue;
    const Mount found = Found(state.vehicle_from_camera, state.sigma);
    Mount& mount = mounts_.back();
    mount.found = true;
    mount.sigma = found.sigma;
    if (!AreClose(found.vehicle_from_camera, mount.vehicle_from_camera))
      mount.vehicle_from_camera = found.vehicle_from_camera;
  }
}

void MountCalibration::AddJump(int keyframe, const MountJump& jump) {
  jumps_.push_back({keyframe, jump, (StartAfter(jumps_.end()) * jump.before_from_after).normalized()});
}

Eigen::Quaterniond MountCalibration::StartAfter(std::vector<Jump>::const_iterator next) const {
  return next == jumps_.begin() ? Eigen::Quaterniond::Identity() : std::prev(next)->start_from_after;
}

Eigen::Quaterniond MountCalibration::StartFromKeyframe(int keyframe) const {
  return StartAfter(std::ranges::upper_bound(jumps_, keyframe, {}, &Jump::first_keyframe));
}

Eigen::Quaterniond MountCalibration::StartFromFrame(int frame) const {
  return StartAfter(
      std::ranges::upper_bound(jumps_, frame, {}, [](const Jump& jump) { return jump.jump.first_frame; }));
}

const Mount& MountCalibration::MountAt(int keyframe) const {
  const auto later = [](int k, const Mount& mount) { return k < mount.first_keyframe; };
  return *std::prev(std::upper_bound(mounts_.begin() + 1, mounts_.end(), keyframe, later));
}

Eigen::Quaterniond MountCalibration::At(int keyframe) const {
  const Eigen::Quaterniond& vehicle_from_camera = MountAt(keyframe).vehicle_from_camera;
  return jumps_.empty() ? vehicle_from_camera : vehicle_from_camera * StartFromKeyframe(keyframe);
}

Eigen::Quaterniond MountCalibration::At(int keyframe, int frame) const {
  const Eigen::Quaterniond& vehicle_from_camera = MountAt(keyframe).vehicle_from_camera;
  return jumps_.empty() ? vehicle_from_camera : vehicle_from_camera * StartFromFrame(frame);
}

Mount MountCalibration::current() const {
  Mount mount = mounts_.back();
  if (!jumps_.empty()) mount.vehicle_from_camera = mount.vehicle_from_camera * jumps_.back().start_from_after;
  return mount;
}

Eigen::Quaterniond MountCalibration::FrameFromLast(int frame) const {
  return StartFromFrame(frame).conjugate() * StartAfter(jumps_.end());
}

std::vector<MountJump> MountCalibration::jumps() const {
  std::vector<MountJump> jumps;
  for (const Jump& jump : jumps_) jumps.push_back(jump.jump);
  return jumps;
}

bool MountCalibration::HasJumpsMissedBy(const MountCalibration& other) const {
  return std::any_of(jumps_.begin() + static_cast<std::ptrdiff_t>(other.jumps_.size()), jumps_.end(),
                     [&](const Jump& jump) { return jump.first_keyframe < other.next_keyframe(); });
}

}  // namespace turnscale
