// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <span>

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// The camera was turned on the car between two frames, as by a knock.
struct MountJump {
  int first_frame = 0;                                                    ///< the first one after it
  double time = 0;                                                        ///< of that frame, seconds
  Eigen::Quaterniond before_from_after = Eigen::Quaterniond::Identity();  ///< rotation of camera axes
  double yaw = 0;                                                         ///< rad, positive to the right
};

/// Detects jumps of the camera's yaw on the car, from the motion between frames: the yaw within one or two intervals
/// (the shortest multiple of the time between frames that is at least 0.08 s) differs from what the turning rates
/// before and after it imply, and from what the curvature of the path implies, by more than that of a car does. It does
/// not detect slower moves, jumps while the car stands or its yaw rate changes unevenly, and a camera that swings back.
class MountJumpDetector {
 public:
  /// Takes the next frame that was tracked, at `time` seconds. `previous_from_current`: its motion since the last one
  /// that was taken; not used for the first one. `vertical`: unit vector along the car's vertical, downwards, in camera
  /// axes. A jump is detected some intervals after it.
  std::optional<MountJump> Add(int frame, double time, const RigidTransform& previous_from_current,
                               const Eigen::Vector3d& vertical);

  /// The unit of length has changed: a length is `factor` times what it was.
  void Rescale(double factor);

  /// The pose of the last frame has been corrected.
  void CorrectLast(const RigidTransform& last_from_corrected);

  /// No frame follows the last one: the motion since then is not measured. Returns a jump that the latest frames show.
  std::optional<MountJump> End();

 private:
  struct Frame {
    int number = 0;
    double time = 0;
    RigidTransform world_from_camera;  // of a world of its own
  };
  struct Candidate {
    MountJump jump;
    double unrest = 0;  // of the intervals beside it: uneven change of the yaw, rad
  };
  std::optional<Candidate> JumpBetween(std::span<const std::size_t> samples, const Eigen::Vector3d& vertical) const;
  std::optional<Candidate> JumpNow(const Eigen::Vector3d& vertical);

  std::deque<Frame> frames_;
  std::optional<Candidate> best_;  // of the intervals that show the jump, the one with the least unrest beside it
};

}  // namespace turnscale
