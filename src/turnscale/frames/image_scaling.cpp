// SPDX-License-Identifier: MIT
#include "turnscale/frames/image_scaling.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Pixel centres are at integers, so that a square of pixels begins half a pixel before the first one's.
double ScaledPlace(double pixel, double pixel_width) { return (pixel + 0.5) / pixel_width - 0.5; }

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

}  // namespace

void ImageOptions::Check() const {
  if (max_width < 0) throw InputError("max_width: must not be negative");
  constexpr int kWidest = 4096;   // pixels: enlarged further, images take memory and show nothing more
  constexpr int kNarrowest = 64;  // pixels: below this, too few patches of features fit into an image
  if (min_width < 0 || min_width > kWidest) throw InputError("min_width: has to be in 0...4096");
  if (max_width > 0 && max_width < kNarrowest)
    throw InputError("max_width: has to be 0 (no limit) or at least 64 pixels");
}

ImageScaling::ImageScaling(const cv::Size& size, const ImageOptions& options) : size_(size) {
  if (size.empty()) return;
  const double widest = options.max_width > 0 ? options.max_width : HUGE_VAL;
  while (Scaled(size).width > widest && size.height >= 2 * reduction_) reduction_ *= 2;
  if (reduction_ > 1) return;
  while (size.width * enlargement_ < options.min_width && 2 * size.width * enlargement_ <= widest) enlargement_ *= 2;
}

cv::Mat ImageScaling::Scaled(const cv::Mat& gray) const {
  if (changes_nothing()) return gray;
  const cv::Size size = Scaled(gray.size());
  const cv::Rect whole_squares({}, size * reduction_ / enlargement_);
  cv::Mat scaled;
  cv::resize(gray(whole_squares), scaled, size, 0, 0, reduction_ > 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  return scaled;
}

cv::Mat ImageScaling::ScaledMask(const cv::Mat& mask) const {
  if (changes_nothing() || mask.empty()) return mask;
  return reduction_ > 1 ? ReducedMask(mask, reduction_) : EnlargedMask(mask, enlargement_);
}

cv::Size ImageScaling::Scaled(const cv::Size& size) const { return size * enlargement_ / reduction_; }

CameraModel ImageScaling::Scaled(CameraModel camera) const {
  if (changes_nothing()) return camera;
  Pinhole& pinhole = camera.pinhole;
  pinhole = {pinhole.fx / pixel_width(), pinhole.fy / pixel_width(), ScaledPlace(pinhole.cx, pixel_width()),
             ScaledPlace(pinhole.cy, pixel_width())};
  camera.focal_sigma /= pixel_width();
  const cv::Size size = Scaled(cv::Size(camera.width, camera.height));
  camera.width = size.width;
  camera.height = size.height;
  return camera;
}

cv::Size ImageScaling::Full(const cv::Size& size) const { return changes_nothing() ? size : size_; }

cv::Mat ImageScaling::FullMask(const cv::Mat& mask) const {
  if (changes_nothing() || mask.empty()) return mask;
  if (enlargement_ > 1) return ReducedMask(mask, enlargement_);
  const cv::Mat squares = EnlargedMask(mask, reduction_);
  cv::Mat full;
  cv::copyMakeBorder(squares, full, 0, size_.height - squares.rows, 0, size_.width - squares.cols,
                     cv::BORDER_REPLICATE);
  return full;
}

CameraModel ImageScaling::Full(CameraModel camera) const {
  if (changes_nothing()) return camera;
  Pinhole& pinhole = camera.pinhole;
  pinhole = {pinhole.fx * pixel_width(), pinhole.fy * pixel_width(), FullPlace(pinhole.cx), FullPlace(pinhole.cy)};
  camera.focal_sigma *= pixel_width();
  camera.width = size_.width;
  camera.height = size_.height;
  return camera;
}

}  // namespace turnscale
