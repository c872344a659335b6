// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// A frame of a camera that goes ahead by `step` from frame to frame, ten times a second, and turns.
inline FrameResult PathFrame(int number, double step = 1, bool posed = true) {
  FrameResult frame;
  frame.frame = number;
  frame.time = 0.1 * number;
  if (!posed) return frame;
  frame.state = TrackingState::kTracked;
  frame.world_from_camera = RigidTransform{RotationFromVector({0, 0.1 * number, 0}), {0, 0, step * number}};
  return frame;
}

inline std::vector<FrameResult> PathFrames(int count, double step) {
  std::vector<FrameResult> frames;
  for (int i = 0; i < count; ++i) frames.push_back(PathFrame(i, step));
  return frames;
}

/// A scale that is held to the end of the drive.
inline RefinedScale HeldScale() {
  RefinedScale scale;
  scale.keyframes.emplace_back().state = ScaleState::kHeld;
  return scale;
}

}  // namespace turnscale
