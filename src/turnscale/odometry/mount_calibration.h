// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/online_calibration.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_jump.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// A move of the camera on the car that shows in the direction of travel.
struct MountMove {
  double time = 0;  ///< seconds; found to about a step of the calibration (StepOptions::duration)
  YawPitchRoll by;  ///< rad, as noticed; yaw and pitch only
};

/// The camera-to-vehicle rotation from a keyframe on.
struct Mount {
  int first_keyframe = 0;
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  bool found = false;       ///< estimated from the drive; else given, assumed, or from before a move
  YawPitchRoll sigma = {};  ///< rad, if estimated
  MountMove move = {};      ///< after which it holds; not of the first
};

/// Whether the camera looks ahead or back: within 40 degrees of the direction of travel, or of the opposite one, as
/// seen from above.
bool LooksAlong(const Eigen::Quaterniond& vehicle_from_camera);

/// The camera-to-vehicle rotation: as given, or found from the drive (section III). A camera that is moved has a new
/// one: after a jump that was measured, what is known of the rotation still holds; after another move, which shows in
/// the direction of travel, it is found anew.
class MountCalibration {
 public:
  explicit MountCalibration(const VehicleOptions& vehicle);

  /// Takes the next keyframes of the drive, whose poses are final; their observations are not used.
  void Learn(std::span<const Keyframe> next);
  /// Takes the new keyframes up to `last`.
  void Learn(const Map& map, int last);
  /// The first keyframe that has not been taken.
  int next_keyframe() const { return next_keyframe_; }

  /// The camera jumped on the car before this keyframe, which may be the next one of the map. It comes after the jumps
  /// so far.
  void AddJump(int keyframe, const MountJump& jump);
  /// Takes the jumps of `other`, which are these and maybe more.
  void TakeJumps(const MountCalibration& other) { jumps_ = other.jumps_; }

  /// The paper's Q at a keyframe.
  Eigen::Quaterniond At(int keyframe) const;
  /// At a frame that belongs to a keyframe, which may be from before a jump.
  Eigen::Quaterniond At(int keyframe, int frame) const;
  /// The latest rotation, after all jumps.
  Mount current() const;

  /// The rotations that were given or found, each from its move on to the next one, in the order of time. Jumps are not
  /// included.
  const std::vector<Mount>& mounts() const { return mounts_; }
  /// How often the camera was moved without a jump, so that its rotation is found anew.
  int moves() const { return static_cast<int>(mounts_.size()) - 1; }
  /// In the order of time.
  std::vector<MountJump> jumps() const;
  /// Rotation of camera axes by the jumps between a frame and the end of the drive.
  Eigen::Quaterniond FrameFromLast(int frame) const;
  /// Whether jumps that `other` lacks come before keyframes that it has taken.
  bool HasJumpsMissedBy(const MountCalibration& other) const;

 private:
  struct Jump {
    int first_keyframe = 0;
    MountJump jump;
    /// Rotation of camera axes, by this jump and all before it.
    Eigen::Quaterniond start_from_after = Eigen::Quaterniond::Identity();
  };
  /// Rotation of camera axes by all jumps up to a keyframe.
  Eigen::Quaterniond StartFromKeyframe(int keyframe) const;
  Eigen::Quaterniond StartFromFrame(int frame) const;
  /// By those before `next`.
  Eigen::Quaterniond StartAfter(std::vector<Jump>::const_iterator next) const;
  const Mount& MountAt(int keyframe) const;
  /// The rotation that the drive gives, each angle averaged with the one that was known before unless they contradict
  /// each other; none where the yaw does.
  Mount Found(const Eigen::Quaterniond& vehicle_from_camera, const YawPitchRoll& sigma) const;
  /// What is known of the latest rotation once it is known to end with a move.
  void EndMount(const OnlineState& state);

  bool calibrates_;
  std::optional<YawPitchRoll> known_;  ///< before the drive
  YawPitchRoll known_sigma_;           ///< rad
  StepGatherer gatherer_;
  OnlineCalibration calibration_;
  std::vector<Mount> mounts_;  ///< jumps are not included
  std::vector<Jump> jumps_;
  std::vector<int> step_ends_;  ///< keyframes
  int next_keyframe_ = 0;
};

}  // namespace turnscale
