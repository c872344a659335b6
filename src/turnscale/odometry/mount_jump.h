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
  int first_frame = 0;                   ///< the first one after it
  Eigen::Quaterniond before_from_after;  ///< to camera axes before it from those after it
};

/// Detects jumps of the camera's yaw on the car, from the motion between frames. Within a tenth or a fifth of a second,
/// the heading of a car does not change by much more than its rate before and after implies, nor by more than the
/// curvature of its path implies. A jump that takes longer, or of a camera that swings back, is not detected.
class MountJumpDetector {
 public:
  /// Takes the next frame that was tracked, at `time` seconds. `previous_from_current`: its motion since the last one
  /// that was taken; not used for the first one. `vertical`: axis of the car's yaw in camera axes, downwards. A jump is
  /// detected some tenths of a second later.
  std::optional<MountJump> Add(int frame, double time, const RigidTransform& previous_from_current,
                               const Eigen::Vector3d& vertical);

  /// The next frame does not follow the last one: its motion since then is not measured.
  void Break() { frames_.clear(); }

 private:
  struct Frame {
    int number = 0;
    double time = 0;
    RigidTransform world_from_camera;  // of a world of its own
  };
  std::optional<MountJump> JumpBetween(std::span<const std::size_t> samples, const Eigen::Vector3d& vertical) const;

  std::deque<Frame> frames_;
};

}  // namespace turnscale
