// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/self_calibration.h"

namespace turnscale {

/// How the images of a drive are scaled before they are processed, and what follows for all that is in pixels. In
/// reduced images, each pixel is the mean of a square of pixels; those at the right and lower edge that fill no square
/// are left out. Images are enlarged by cubic interpolation.
class ImageScaling {
 public:
  /// No scaling.
  ImageScaling() = default;
  /// Scaling of images of this size as `options` have it.
  ImageScaling(const cv::Size& size, const ImageOptions& options);

  /// Width of a processed pixel in pixels of the full image, a power of two: above 1 for reduced, below 1 for enlarged
  /// images.
  double pixel_width() const { return pixel_width_; }

  /// From full size to the size that is processed.
  cv::Mat Scaled(const cv::Mat& gray) const;
  /// A pixel of a reduced mask is 0 if one of its square is.
  cv::Mat ScaledMask(const cv::Mat& mask) const;
  cv::Size Scaled(const cv::Size& size) const;
  CameraModel Scaled(CameraModel camera) const;

  /// From the size that is processed to full size. A pixel of the mask is 0 if one of those it was enlarged to is.
  cv::Size Full(const cv::Size& size) const;
  cv::Mat FullMask(const cv::Mat& mask) const;
  CameraModel Full(CameraModel camera) const;
  FoundCamera Full(FoundCamera found) const;
  ParameterEstimate Full(ParameterEstimate estimate) const;

 private:
  cv::Size size_;  // at full size; empty if not known
  double pixel_width_ = 1;
};

}  // namespace turnscale
