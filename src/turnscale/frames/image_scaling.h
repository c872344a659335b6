// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// How the images of a drive are scaled when they are read.
struct ImageOptions {
  /// Images wider than this, pixels, are halved until they are not: twice the pixels a side cost four times the time,
  /// and add little. 0: none are.
  int max_width = 2048;
  /// Images narrower than this, pixels, are doubled until they are not, but never beyond `max_width`: patches of
  /// features have a fixed number of pixels and cover too large a part of a small image. 0: none are.
  int min_width = 480;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Images are taken as they are.
inline constexpr ImageOptions kUnscaled{.max_width = 0, .min_width = 0};

/// How the images of a drive are scaled before they are processed, and what follows for all that is in pixels. In a
/// reduced image, each pixel is the mean of a square of pixels; those at the right and lower edge that fill no square
/// are left out. Images are enlarged by cubic interpolation.
class ImageScaling {
 public:
  /// No scaling.
  ImageScaling() = default;
  /// Scaling of images of this size as `options` have it.
  ImageScaling(const cv::Size& size, const ImageOptions& options);

  /// Width of a processed pixel in pixels of the full image, a power of two: above 1 for reduced, below 1 for enlarged
  /// images.
  double pixel_width() const { return static_cast<double>(reduction_) / enlargement_; }

  /// From full size to the size that is processed.
  cv::Mat Scaled(const cv::Mat& gray) const;
  /// In a reduced mask, a pixel is 0 if any pixel of its square is. Where images are enlarged, pixels beside a masked
  /// one are not masked, although masked pixels take part in their interpolation.
  cv::Mat ScaledMask(const cv::Mat& mask) const;
  cv::Size Scaled(const cv::Size& size) const;
  /// An image size of 0, unknown, stays 0.
  CameraModel Scaled(CameraModel camera) const;

  /// From the size that is processed to full size. `size` is that of the images that are processed.
  cv::Size Full(const cv::Size& size) const;
  /// Where images are enlarged, a pixel is 0 if any of its enlarged pixels is.
  cv::Mat FullMask(const cv::Mat& mask) const;
  CameraModel Full(CameraModel camera) const;
  /// A coordinate of a pixel.
  double FullPlace(double pixel) const { return (pixel + 0.5) * pixel_width() - 0.5; }

 private:
  bool changes_nothing() const { return reduction_ == enlargement_; }

  cv::Size size_;  // at full size; empty if not known
  // Sides of the squares, of which one is a single pixel: of full pixels that become one, and of what one becomes.
  int reduction_ = 1;
  int enlargement_ = 1;
};

}  // namespace turnscale
