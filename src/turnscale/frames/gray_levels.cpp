// SPDX-License-Identifier: MIT
#include "turnscale/frames/gray_levels.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

constexpr int kAllBits = 16;

int BitsFor(double level) {
  for (const int bits : {8, 10, 12, 14})
    if (level < std::ldexp(1, bits)) return bits;
  return kAllBits;
}

}  // namespace

cv::Mat GrayLevels::ToGray8(const cv::Mat& image, bool range_is_stated) {
  cv::Mat gray = image;
  if (image.channels() == 3) cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  if (image.channels() == 4) cv::cvtColor(image, gray, cv::COLOR_BGRA2GRAY);
  if (gray.depth() == CV_16U && gray.channels() == 1) {
    if (!range_is_stated) CoverLevels(gray);
    const int bits = range_is_stated || bits_ == 0 ? kAllBits : bits_;
    gray.convertTo(gray, CV_8U, std::ldexp(1, 8 - bits));
  }
  return gray.depth() == CV_8U && gray.channels() == 1 ? gray : cv::Mat();
}

std::string GrayLevels::TakeNotice() { return std::exchange(notice_, {}); }

void GrayLevels::CoverLevels(const cv::Mat& gray) {
  if (bits_ == kAllBits) return;
  double brightest = 0;
  cv::minMaxLoc(gray, nullptr, &brightest);
  // A lens that is covered does not tell.
  constexpr double kBlack = 32;
  if (bits_ == 0 && brightest < kBlack) return;
  const int bits = BitsFor(brightest);
  if (bits <= bits_) return;
  if (bits_ > 0) {
    notice_ = fmt::format(
        "the levels of the 16-bit images exceed {} bits from here on, up to {:.0f}: they are read as "
        "{} bits; tracking may suffer at this image",
        bits_, brightest, bits);
  } else if (bits < kAllBits) {
    notice_ = fmt::format("the 16-bit images are read as {} bits: the brightest level of the first one is {:.0f}", bits,
                          brightest);
  }
  bits_ = bits;
}

}  // namespace turnscale
