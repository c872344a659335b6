// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <opencv2/core.hpp>

namespace turnscale {

constexpr int kMostFlowWindow = 31;

/// Pixels around an image, in the same memory, that TrackPatch may read.
constexpr int kFlowBorder = 48;

struct LucasKanadeOptions {
  /// Side of the square patch that is compared, pixels. Odd, at most kMostFlowWindow.
  int window = 15;
  int max_iterations = 30;
  /// Steps shorter than this end the search, pixels.
  float tolerance = 0.03F;
};

/// Where the second image shows the patch around `point` of the first one: translation only, by the inverse
/// compositional method (Baker and Matthews 2004), starting at `guess`. Both images are 8-bit gray with kFlowBorder
/// pixels of border. Empty where the patch is flat, or the search leaves the image.
///
/// Gray levels are interpolated in 16-bit integers, and sums are added in a fixed order.
std::optional<cv::Point2f> TrackPatch(const LucasKanadeOptions& options, const cv::Mat& first, const cv::Point2f& point,
                                      const cv::Mat& second, const cv::Point2f& guess);

}  // namespace turnscale
