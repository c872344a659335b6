// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// Converts the images of a drive, in their order, to 8-bit gray. Cameras of 10, 12 or 14 bits fill only the lower
/// levels of 16-bit images: the range that becomes 8 bits is the smallest of 8, 10, 12, 14 and 16 bits that holds the
/// first image that is not nearly black. It is the same for all images, so that brightness does not flicker; it widens
/// at an image that exceeds it, as on the way out of a dark garage.
class GrayLevels {
 public:
  /// Any image type as 8-bit gray; empty for types that are neither 8 nor 16 bit. `range_is_stated`: by the file, so
  /// that all 16 bits are its range.
  cv::Mat ToGray8(const cv::Mat& image, bool range_is_stated = false);

  /// What the user should know about the range of the images so far, one line, which is given once; may be empty.
  std::string TakeNotice();

 private:
  void CoverLevels(const cv::Mat& gray);

  int bits_ = 0;  // of the range; 0 before the first 16-bit image that is not black
  std::string notice_;
};

}  // namespace turnscale
