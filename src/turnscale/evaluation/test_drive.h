// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "turnscale/evaluation/association.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// A drive through bends, up and down a little, one pose each 0.1 s and `step` metres; it starts at identity.
inline Trajectory WindingDrive(int poses, double step = 1.0) {
  Trajectory drive;
  RigidTransform pose;
  for (int i = 0; i < poses; ++i) {
    drive.push_back({0.1 * i, pose});
    const double yaw = 0.05 * std::sin(0.03 * i);
    pose = pose * RigidTransform{RotationFromVector({0.002 * std::sin(0.1 * i), yaw, 0.0}),
                                 {step * std::sin(0.5 * yaw), 0.0, step * std::cos(0.5 * yaw)}};
  }
  return drive;
}

/// The same drive with every position multiplied.
inline Trajectory Scaled(Trajectory drive, double scale) {
  for (StampedPose& pose : drive) pose.world_from_camera.translation *= scale;
  return drive;
}

/// The same drive seen from another world frame.
inline Trajectory Moved(Trajectory drive, const RigidTransform& other_from_world) {
  for (StampedPose& pose : drive) pose.world_from_camera = other_from_world * pose.world_from_camera;
  return drive;
}

}  // namespace turnscale
