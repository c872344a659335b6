// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// The camera's motion from one frame to the next, as a mean over some frames: the paper's hat R_j, hat t_j, with
/// less noise. In the odometry's own unit of length.
///
/// Each frame's motion is taken in its own camera frame, half-way through its rotation: on a bend the camera then goes
/// the same way in every frame, so means obey the kinematics however long the bend is and however unequal the frames
/// are. The chord of a long step does not, nor does a mean of the directions seen from where the frames begin. Noise
/// that is independent from frame to frame averages out.
struct CameraStep {
  RigidTransform previous_from_current;  ///< of one frame
  int frames = 1;
  double begin = 0;  ///< seconds
  double end = 0;    ///< seconds
};

/// The step as one motion: its first pose from its last, had the camera moved in every frame as on the mean.
inline RigidTransform WholeMotion(const CameraStep& step) {
  const Eigen::Vector3d rotation = VectorFromRotation(step.previous_from_current.rotation);
  return {
      RotationFromVector(step.frames * rotation),
      step.frames * (RotationFromVector(0.5 * (step.frames - 1) * rotation) * step.previous_from_current.translation)};
}

/// Reversing obeys the same kinematics with time inverted: the step as if the car drove forward.
inline CameraStep Reversed(CameraStep step) {
  step.previous_from_current = step.previous_from_current.inverse();
  return step;
}

}  // namespace turnscale
