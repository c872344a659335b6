// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// Contrast of an image: standard deviation of the mean gray levels of its blocks of 8x8 pixels, in which the noise of
/// single pixels hardly counts. Gray is 8 bit; blocks in which `mask` has a 0 are left out (as ImageMask::pixels).
double ContrastOf(const cv::Mat& gray, const cv::Mat& mask);

}  // namespace turnscale
