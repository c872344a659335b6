// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/odometry/self_calibration.h"

namespace turnscale {

/// How the images of a drive are reduced before they are processed, and what follows for all that is in pixels: each
/// pixel is the mean of a square of `factor` x `factor` pixels. Pixels at the right and lower edge that fill no square
/// are left out. With a factor of 1 everything stays as it is.
class ImageReduction {
 public:
  ImageReduction() = default;
  /// Images of this size are halved until they are at most `max_width` pixels wide; 0: they are not.
  ImageReduction(const cv::Size& size, int max_width);

  int factor() const { return factor_; }

  /// From full size to the size that is processed.
  cv::Mat Reduced(const cv::Mat& gray) const;
  /// A pixel of the mask is 0 if one of its square is.
  cv::Mat ReducedMask(const cv::Mat& mask) const;
  CameraModel Reduced(CameraModel camera) const;

  /// From the size that is processed to full size.
  cv::Size Full(const cv::Size& size) const;
  cv::Mat FullMask(const cv::Mat& mask) const;
  CameraModel Full(CameraModel camera) const;
  FoundCamera Full(FoundCamera found) const;
  ParameterEstimate Full(ParameterEstimate estimate) const;

 private:
  cv::Size size_;  // at full size; empty if not known
  int factor_ = 1;
};

}  // namespace turnscale
