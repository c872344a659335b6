// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "turnscale/geometry/rotation.h"
#include "turnscale/run/result_folder.h"

namespace turnscale {

/// Results of a run at 10 m/s and 10 frames/s along a circle to the right, of this radius in metres.
inline ResultFolder TestResults(int frames, double radius = 200) {
  ResultFolder results;
  results.metric = true;
  for (int i = 0; i < frames; ++i) {
    FrameResult frame;
    frame.frame = i;
    frame.time = 0.1 * i;
    frame.state = TrackingState::kTracked;
    frame.scale_state = ScaleState::kHeld;
    frame.scale_sigma = 0.02;
    const double heading = i / radius;
    frame.world_from_camera = RigidTransform{RotationFromVector({0, heading, 0}),
                                             {radius * (1 - std::cos(heading)), 0, radius * std::sin(heading)}};
    results.frames.push_back(frame);
    if (i > 0) results.speeds.push_back({frame.time, 10, 0.25});
  }
  return results;
}

}  // namespace turnscale
