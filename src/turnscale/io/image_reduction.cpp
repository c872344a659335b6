// SPDX-License-Identifier: MIT
#include "turnscale/io/image_reduction.h"

#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

// Pixel centres are at integers: the first square's centre is at (factor - 1) / 2.
double ReducedPlace(double pixel, int factor) { return (pixel + 0.5) / factor - 0.5; }
double FullPlace(double pixel, int factor) { return (pixel + 0.5) * factor - 0.5; }

cv::Mat MeansOfSquares(const cv::Mat& image, int factor) {
  const cv::Size size = image.size() / factor;
  cv::Mat means;
  cv::resize(image(cv::Rect({}, size * factor)), means, size, 0, 0, cv::INTER_AREA);
  return means;
}

}  // namespace

ImageReduction::ImageReduction(const cv::Size& size, int max_width) : size_(size) {
  while (max_width > 0 && size.width / factor_ > max_width && size.height >= 2 * factor_) factor_ *= 2;
}

cv::Mat ImageReduction::Reduced(const cv::Mat& gray) const {
  return factor_ == 1 ? gray : MeansOfSquares(gray, factor_);
}

cv::Mat ImageReduction::ReducedMask(const cv::Mat& mask) const {
  if (factor_ == 1 || mask.empty()) return mask;
  cv::Mat used;
  cv::erode(mask, used, cv::Mat::ones(factor_, factor_, CV_8U), cv::Point(0, 0));
  cv::Mat reduced;
  const cv::Size size = mask.size() / factor_;
  cv::resize(used(cv::Rect({}, size * factor_)), reduced, size, 0, 0, cv::INTER_NEAREST);
  return reduced;
}

CameraModel ImageReduction::Reduced(CameraModel camera) const {
  if (factor_ == 1) return camera;
  Pinhole& pinhole = camera.pinhole;
  pinhole = {pinhole.fx / factor_, pinhole.fy / factor_, ReducedPlace(pinhole.cx, factor_),
             ReducedPlace(pinhole.cy, factor_)};
  camera.focal_sigma /= factor_;
  camera.width /= factor_;
  camera.height /= factor_;
  return camera;
}

cv::Size ImageReduction::Full(const cv::Size& size) const { return factor_ == 1 ? size : size_; }

cv::Mat ImageReduction::FullMask(const cv::Mat& mask) const {
  if (factor_ == 1 || mask.empty()) return mask;
  cv::Mat squares;
  cv::resize(mask, squares, mask.size() * factor_, 0, 0, cv::INTER_NEAREST);
  cv::Mat full;
  cv::copyMakeBorder(squares, full, 0, size_.height - squares.rows, 0, size_.width - squares.cols,
                     cv::BORDER_REPLICATE);
  return full;
}

CameraModel ImageReduction::Full(CameraModel camera) const {
  if (factor_ == 1) return camera;
  Pinhole& pinhole = camera.pinhole;
  pinhole = {pinhole.fx * factor_, pinhole.fy * factor_, FullPlace(pinhole.cx, factor_),
             FullPlace(pinhole.cy, factor_)};
  camera.focal_sigma *= factor_;
  camera.width = size_.width;
  camera.height = size_.height;
  return camera;
}

FoundCamera ImageReduction::Full(FoundCamera found) const {
  found.camera = Full(found.camera);
  found.centre_sigma *= factor_;
  return found;
}

ParameterEstimate ImageReduction::Full(ParameterEstimate estimate) const {
  switch (estimate.parameter) {
    case IntrinsicsParameter::kFocalLength:
      estimate.given *= factor_;
      estimate.found *= factor_;
      break;
    case IntrinsicsParameter::kCentreX:
    case IntrinsicsParameter::kCentreY:
      estimate.given = FullPlace(estimate.given, factor_);
      estimate.found = FullPlace(estimate.found, factor_);
      break;
    case IntrinsicsParameter::kDistortion:
      return estimate;
  }
  estimate.sigma *= factor_;
  return estimate;
}

}  // namespace turnscale
