// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace turnscale {

/// A pattern of reflectance that repeats in both directions, halved from level to level.
class Texture {
 public:
  /// `pattern`: CV_32F, square, side a power of two, reflectance 0...1. It covers `size` x `size` metres.
  /// Throws std::invalid_argument for another shape.
  Texture(const cv::Mat& pattern, double size);

  /// Mean over the ellipse around `at` with half axes `major` and `minor` (metres; `minor` is a length, perpendicular
  /// to `major` and no longer): what a pixel sees that covers it. Trilinear, several samples along a long axis.
  float Sample(const Eigen::Vector2f& at, const Eigen::Vector2f& major, float minor) const;

  /// Side of the square that repeats, metres.
  double size() const { return size_; }

 private:
  struct Level {
    cv::Mat pixels;  ///< CV_32F, continuous
    int shift = 0;   ///< log2 of the side
    float pixels_per_metre = 1;
  };

  static float Bilinear(const Level& level, const Eigen::Vector2f& at);

  double size_;
  std::vector<Level> levels_;  ///< finest first, each half the one before, down to one pixel
};

}  // namespace turnscale
