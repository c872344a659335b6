// SPDX-License-Identifier: MIT
#include "turnscale/run/frame_warnings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "turnscale/geometry/angle.h"

namespace turnscale {

std::string SkippedWarning(int frame, const std::string& problem) {
  return fmt::format("frame {}: {}; skipped", frame, problem);
}

std::string CameraMoveText(const MountMove& move, double first_time) {
  constexpr double kLittle = 0.5;  // degrees: the sigma of such an angle
  const auto part = [](double degrees, const char* positive, const char* negative) {
    return fmt::format("{:.1f} degrees {}", std::abs(degrees), degrees > 0 ? positive : negative);
  };
  std::vector<std::string> parts;
  const double yaw = InDegrees(move.by.yaw);
  const double pitch = InDegrees(move.by.pitch);
  if (std::abs(yaw) >= kLittle) parts.push_back(part(yaw, "to the right", "to the left"));
  if (std::abs(pitch) >= kLittle) parts.push_back(part(pitch, "up", "down"));
  return fmt::format("by about {} at {:.0f} s", fmt::join(parts, " and "), move.time - first_time);
}

std::string CameraMovedWarning(int frame, const MountMove& move, double first_time) {
  return fmt::format(
      "frame {}: the camera was turned on the car {}, as found now; its rotation from then on is estimated anew: check "
      "that the camera is fixed",
      frame, CameraMoveText(move, first_time));
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
