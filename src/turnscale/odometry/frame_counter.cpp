// SPDX-License-Identifier: MIT
#include "turnscale/odometry/frame_counter.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "turnscale/base/error.h"
#include "turnscale/base/frame_interval.h"
#include "turnscale/base/number_text.h"

namespace turnscale {

void FrameCounter::Check(double time) const {
  const std::string named = "time " + std::to_string(time) + " s: ";
  if (!std::isfinite(time)) throw InputError(named + "has to be a finite number");
  if (!(time > last_frame_time_)) throw InputError(named + "has to be after the frame before");
  constexpr int kFewestFrames = 8;
  const double least_interval = std::min(least_interval_, time - last_frame_time_);
  if (frames_ >= kFewestFrames && least_interval > kLongestFrameInterval)
    throw InputError(named + "all frames so far are " + NumberText(least_interval) +
                     " s apart or more; are the times milliseconds or nanoseconds? Give seconds");
}

int FrameCounter::Add(double time) {
  least_interval_ = std::min(least_interval_, time - last_frame_time_);
  last_frame_time_ = time;
  return frames_++;
}

}  // namespace turnscale
