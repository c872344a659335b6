// SPDX-License-Identifier: MIT
#include "turnscale/io/image_scaling.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

// Pixel centres are at integers, so that a square of pixels begins half a pixel before the first one's.
double ScaledPlace(double pixel, double pixel_width) { return (pixel + 0.5) / pixel_width - 0.5; }
double FullPlace(double pixel, double pixel_width) { return (pixel + 0.5) * pixel_width - 0.5; }

// Each pixel is 0 if one of its square is.
cv::Mat ReducedMask(const cv::Mat& mask, int side) {
  cv::Mat used;
  cv::erode(mask, used, cv::Mat::ones(side, side, CV_8U), cv::Point(0, 0));
  cv::Mat reduced;
  const cv::Size size = mask.size() / side;
  cv::resize(used(cv::Rect({}, size * side)), reduced, size, 0, 0, cv::INTER_NEAREST);
  return reduced;
}

cv::Mat EnlargedMask(const cv::Mat& mask, int side) {
  cv::Mat enlarged;
  cv::resize(mask, enlarged, mask.size() * side, 0, 0, cv::INTER_NEAREST);
  return enlarged;
}

// Side of the square of full pixels that one processed pixel stands for.
int Reduction(double pixel_width) { return static_cast<int>(std::lround(pixel_width)); }
// Side of the square of processed pixels that one full pixel becomes.
int Enlargement(double pixel_width) { return static_cast<int>(std::lround(1 / pixel_width)); }

}  // namespace

ImageScaling::ImageScaling(const cv::Size& size, const ImageOptions& options) : size_(size) {
  if (size.empty()) return;
  const double widest = options.max_width > 0 ? options.max_width : HUGE_VAL;
  while (Scaled(size).width > widest && size.height >= 2 * pixel_width_) pixel_width_ *= 2;
  while (Scaled(size).width < options.min_width && 2 * Scaled(size).width <= widest) pixel_width_ /= 2;
}

cv::Mat ImageScaling::Scaled(const cv::Mat& gray) const {
  if (pixel_width_ == 1) return gray;
  cv::Mat scaled;
  if (pixel_width_ < 1) {
    cv::resize(gray, scaled, Scaled(gray.size()), 0, 0, cv::INTER_CUBIC);
    return scaled;
  }
  const cv::Size size = Scaled(gray.size());
  cv::resize(gray(cv::Rect({}, size * Reduction(pixel_width_))), scaled, size, 0, 0, cv::INTER_AREA);
  return scaled;
}

cv::Mat ImageScaling::ScaledMask(const cv::Mat& mask) const {
  if (pixel_width_ == 1 || mask.empty()) return mask;
  return pixel_width_ > 1 ? ReducedMask(mask, Reduction(pixel_width_)) : EnlargedMask(mask, Enlargement(pixel_width_));
}

cv::Size ImageScaling::Scaled(const cv::Size& size) const {
  return pixel_width_ < 1 ? size * Enlargement(pixel_width_) : size / Reduction(pixel_width_);
}

CameraModel ImageScaling::Scaled(CameraModel camera) const {
  if (pixel_width_ == 1) return camera;
  Pinhole& pinhole = camera.pinhole;
  pinhole = {pinhole.fx / pixel_width_, pinhole.fy / pixel_width_, ScaledPlace(pinhole.cx, pixel_width_),
             ScaledPlace(pinhole.cy, pixel_width_)};
  camera.focal_sigma /= pixel_width_;
  const cv::Size size = Scaled(cv::Size(camera.width, camera.height));
  camera.width = size.width;
  camera.height = size.height;
  return camera;
}

cv::Size ImageScaling::Full(const cv::Size& size) const { return pixel_width_ == 1 ? size : size_; }

cv::Mat ImageScaling::FullMask(const cv::Mat& mask) const {
  if (pixel_width_ == 1 || mask.empty()) return mask;
  if (pixel_width_ < 1) return ReducedMask(mask, Enlargement(pixel_width_));
  const cv::Mat squares = EnlargedMask(mask, Reduction(pixel_width_));
  cv::Mat full;
  cv::copyMakeBorder(squares, full, 0, size_.height - squares.rows, 0, size_.width - squares.cols,
                     cv::BORDER_REPLICATE);
  return full;
}

CameraModel ImageScaling::Full(CameraModel camera) const {
  if (pixel_width_ == 1) return camera;
  Pinhole& pinhole = camera.pinhole;
  pinhole = {pinhole.fx * pixel_width_, pinhole.fy * pixel_width_, FullPlace(pinhole.cx, pixel_width_),
             FullPlace(pinhole.cy, pixel_width_)};
  camera.focal_sigma *= pixel_width_;
  camera.width = size_.width;
  camera.height = size_.height;
  return camera;
}

FoundCamera ImageScaling::Full(FoundCamera found) const {
  found.camera = Full(found.camera);
  found.centre_sigma *= pixel_width_;
  return found;
}

ParameterEstimate ImageScaling::Full(ParameterEstimate estimate) const {
  switch (estimate.parameter) {
    case IntrinsicsParameter::kFocalLength:
      estimate.given *= pixel_width_;
      estimate.found *= pixel_width_;
      break;
    case IntrinsicsParameter::kCentreX:
    case IntrinsicsParameter::kCentreY:
      estimate.given = FullPlace(estimate.given, pixel_width_);
      estimate.found = FullPlace(estimate.found, pixel_width_);
      break;
    case IntrinsicsParameter::kDistortion:
      return estimate;
  }
  estimate.sigma *= pixel_width_;
  return estimate;
}

}  // namespace turnscale
