// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/online_calibration.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// The camera-to-vehicle rotation from a keyframe on, up to the next Mount's.
struct Mount {
  int first_keyframe = 0;
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  bool found = false;       ///< estimated from the drive; else given, assumed, or from before a move
  YawPitchRoll sigma = {};  ///< rad, if estimated
};

/// The camera-to-vehicle rotation: as given, or found from the drive (section III).
class MountCalibration {
 public:
  explicit MountCalibration(const VehicleOptions& vehicle);

  /// Takes the next keyframes of the drive, whose poses are final; their observations are not used.
  void Learn(std::span<const Keyframe> next);
  /// Takes the new keyframes up to `last`.
  void Learn(const Map& map, int last);
  /// The first keyframe that has not been taken.
  int next_keyframe() const { return next_keyframe_; }

  /// The paper's Q at a keyframe.
  const Eigen::Quaterniond& At(int keyframe) const;
  const Mount& current() const { return mounts_.back(); }

  /// The rotations in use, in the order of time.
  const std::vector<Mount>& mounts() const { return mounts_; }
  /// How often the camera was moved.
  int moves() const { return static_cast<int>(mounts_.size()) - 1; }

 private:
  /// The rotation that the drive gives, each angle averaged with the one that was known before unless they contradict
  /// each other; none where the yaw does.
  Mount Found(const OnlineState& state) const;

  bool calibrates_;
  std::optional<YawPitchRoll> known_;  ///< before the drive
  YawPitchRoll known_sigma_;           ///< rad
  StepGatherer gatherer_;
  OnlineCalibration calibration_;
  std::vector<Mount> mounts_;
  std::vector<int> step_ends_;  ///< keyframes
  int next_keyframe_ = 0;
};

}  // namespace turnscale
