// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace turnscale {

/// A pattern of reflectance that repeats in both directions, halved from level to level.
class Texture {
 public:
  /// `pattern`: CV_32F, square, side a power of two, reflectance 0...1. It covers `size` x `size` metres.
  /// Throws InternalError for another shape.
  Texture(const cv::Mat& pattern, double size);

  /// Mean over the ellipse around `at` with half axes `major` and `minor` (metres; `minor` is a length, perpendicular
  /// to `major` and no longer): what a pixel sees that covers it. Trilinear, several samples along a long axis.
  float Sample(const Eigen::Vector2f& at, const Eigen::Vector2f& major, float minor) const;

  /// The same with its differences from the mean multiplied.
  Texture WithContrast(float factor) const;

  /// Side of the square that repeats, metres.
  double size() const { return size_; }

 private:
  /// Pixels, the first column again after the last one and the first row again below: bilinear samples need not look
  /// for the pattern's edge.
  struct Level {
    int shift = 0;  ///< log2 of the side
    std::vector<float> pixels;
  };

  double size_;
  float per_metre_ = 1;  ///< turns of the pattern in a metre
  float pixels_per_metre_ = 1;
  /// Finest first, each half the one before, down to one pixel. Copies of a texture share them.
  std::shared_ptr<const std::vector<Level>> levels_;
};

}  // namespace turnscale
