// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// How far the rays that two cameras give to a pixel are apart.
struct RayDifference {
  double angle = 0;     ///< rad
  double distance = 0;  ///< on the plane z = 1, in focal lengths
};

/// The largest of both over a grid of 15 pixels of an image of this size (pixels). Those that are farther than `radius`
/// (pixels) from the principal point of `camera` are moved there towards it. Nothing where a camera has no ray for one.
std::optional<RayDifference> LargestRayDifference(const CameraModel& camera, const CameraModel& other, int width,
                                                  int height, double radius = HUGE_VAL);

}  // namespace turnscale
