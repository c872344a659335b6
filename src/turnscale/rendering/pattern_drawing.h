// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/rendering/pattern.h"

namespace turnscale {

/// Throws InternalError where the side is not a power of two of at least 16.
void CheckSide(const PatternOptions& options);

/// Noise of all sizes (see CloudPattern), mean 0 and standard deviation 1.
cv::Mat Clouds(int side, std::uint64_t seed, double roughness);

/// Shifts and stretches a pattern to the mean and contrast that are asked for, and keeps it within what surfaces
/// reflect.
void Finish(const PatternOptions& options, cv::Mat& pattern);

/// Calls `paint` (value of a pixel, and its place from the centre) for every pixel within `reach` of a centre, around
/// the edges of the pattern.
template <typename Paint>
void PaintAround(const Eigen::Vector2f& centre, float reach, const Paint& paint, cv::Mat& pattern) {
  const int mask = pattern.rows - 1;
  const int top = static_cast<int>(std::floor(centre.y() - reach));
  const int left = static_cast<int>(std::floor(centre.x() - reach));
  const int bottom = static_cast<int>(std::ceil(centre.y() + reach));
  const int right = static_cast<int>(std::ceil(centre.x() + reach));
  for (int row = top; row <= bottom; ++row) {
    auto* pixels = pattern.ptr<float>(row & mask);
    for (int column = left; column <= right; ++column)
      paint(pixels[column & mask],
            Eigen::Vector2f(static_cast<float>(column) - centre.x(), static_cast<float>(row) - centre.y()));
  }
}

/// 0 below `from`, 1 above `to`, smooth between.
inline float Smooth(float from, float to, float x) {
  const float t = std::min(1.0F, std::max(0.0F, (x - from) / (to - from)));
  return t * t * (3 - 2 * t);
}

}  // namespace turnscale
