// SPDX-License-Identifier: MIT
#include "turnscale/camera/ray_difference.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace turnscale {

std::optional<RayDifference> LargestRayDifference(const CameraModel& camera, const CameraModel& other, int width,
                                                  int height, double radius) {
  const Eigen::Vector2d centre(camera.pinhole.cx, camera.pinhole.cy);
  RayDifference largest;
  for (const double x : {0.0, 0.25, 0.5, 0.75, 1.0})
    for (const double y : {0.0, 0.5, 1.0}) {
      const Eigen::Vector2d place(x * (width - 1), y * (height - 1));
      const double share = std::min(1.0, radius / std::max(1.0, (place - centre).norm()));
      const Eigen::Vector2d pixel = centre + share * (place - centre);
      const auto one = camera.Undistort(pixel);
      const auto two = other.Undistort(pixel);
      if (!one || !two) return std::nullopt;
      const Eigen::Vector3d first = camera.pinhole.Ray(*one);
      const Eigen::Vector3d second = other.pinhole.Ray(*two);
      largest.angle = std::max(largest.angle, std::atan2(first.cross(second).norm(), first.dot(second)));
      largest.distance = std::max(largest.distance, (first - second).norm());
    }
  return largest;
}

}  // namespace turnscale
