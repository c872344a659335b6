// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include <Eigen/Core>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// Where the ray of a distorted pixel meets the plane z = 1; nothing where the pixel has no ray.
using RayOfPixel = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d&)>;

/// The camera with these intrinsics and this image size (pixels) whose lens comes closest to rays that are distorted
/// along the radius, over the pixels within `radius` (pixels) of the principal point. The lens is a pinhole where that
/// is exact to 0.1 pixel, else the radial-tangential model with two coefficients where that is exact to 0.3 pixel, else
/// that or the equidistant one with three, whichever is closer; of two that are exact to 0.3 pixel, one that has a ray
/// for every pixel is preferred. Beyond the radius the model extrapolates, and may have no ray. Nothing where neither
/// has a single ray for every pixel within the radius. Nothing, too, where fewer than half of these pixels have a ray,
/// or fewer than ten of the 425 that are sampled over the image.
///
/// `tangential`: p1 and p2 of a radial-tangential lens, by which the rays are distorted besides. They are kept; the
/// equidistant model, where the other has no single ray for every pixel within the radius, cannot have them.
std::optional<CameraModel> FitLens(const Pinhole& pinhole, int width, int height, const RayOfPixel& ray_of,
                                   double radius = HUGE_VAL, const std::array<double, 2>& tangential = {0, 0});

}  // namespace turnscale
