// SPDX-License-Identifier: MIT
#include "turnscale/odometry/image_contrast.h"

#include <opencv2/imgproc.hpp>

namespace turnscale {

double ContrastOf(const cv::Mat& gray, const cv::Mat& mask) {
  constexpr double kShrink = 1.0 / 8;
  cv::Mat blocks;
  cv::resize(gray, blocks, cv::Size(), kShrink, kShrink, cv::INTER_AREA);
  cv::Mat whole;
  if (!mask.empty()) {
    cv::resize(mask, whole, blocks.size(), 0, 0, cv::INTER_AREA);
    cv::threshold(whole, whole, 254, 255, cv::THRESH_BINARY);
  }
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(blocks, mean, deviation, whole);
  return deviation[0];
}

}  // namespace turnscale
