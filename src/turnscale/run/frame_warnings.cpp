// SPDX-License-Identifier: MIT
#include "turnscale/run/frame_warnings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "turnscale/geometry/angle.h"

namespace turnscale {

std::string SkippedWarning(int frame, const std::string& problem) {
  return fmt::format("frame {}: {}; skipped", frame, problem);
}

std::string CameraMovedWarning(int frame) {
  return fmt::format(
      "frame {}: the camera was moved earlier in the drive; re-estimating the camera-to-vehicle rotation", frame);
}

std::string CameraJumpText(const MountJump& jump, double first_time) {
  return fmt::format(
      "frame {} (at {:.1f} s): the camera was turned on the car by {:.1f} degrees to the {}, as by a knock",
      jump.first_frame, jump.time - first_time, std::abs(InDegrees(jump.yaw)), jump.yaw > 0 ? "right" : "left");
}

std::string CameraJumpWarning(const MountJump& jump, double first_time) {
  return CameraJumpText(jump, first_time) +
         "; the path allows for it, and car.yaml has the rotation after it: check that the camera is still fixed";
}

std::string UnreadableText(const std::vector<UnreadableFrame>& frames) {
  constexpr size_t kNamed = 5;
  std::string numbers;
  for (size_t i = 0; i < std::min(frames.size(), kNamed); ++i)
    numbers += fmt::format("{}{}", i == 0 ? "" : ", ", frames[i].frame);
  if (frames.size() > kNamed) numbers += fmt::format(" and {} more", frames.size() - kNamed);
  return fmt::format("{} image{} cannot be used: frame{} {} (the first: {})", frames.size(),
                     frames.size() == 1 ? "" : "s", frames.size() == 1 ? "" : "s", numbers, frames.front().problem);
}

}  // namespace turnscale
