// SPDX-License-Identifier: MIT
#include "turnscale/simulation/burnt_clock.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

constexpr int kStartOfDay = 9 * 3600 + 41 * 60 + 30;  // 09:41:30
constexpr int kDay = 24 * 3600;
constexpr double kLettersPerHeight = 36;
// Height of this font's capital letters at scale 1, pixels.
constexpr double kFontHeight = 21;

}  // namespace

std::string ClockText(double seconds) {
  const int second = (kStartOfDay + static_cast<int>(std::floor(seconds))) % kDay;
  return fmt::format("2026-05-17 {:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60);
}

void BurnClock(double seconds, cv::Mat& image) {
  const double letters = image.rows / kLettersPerHeight;
  const double scale = letters / kFontHeight;
  const cv::Point place(static_cast<int>(letters), static_cast<int>(2 * letters));
  const int stroke = std::max(1, static_cast<int>(std::lround(0.1 * letters)));
  for (const auto& [gray, width] : {std::pair(0, 3 * stroke), std::pair(255, stroke)}) {
    cv::putText(image, ClockText(seconds), place, cv::FONT_HERSHEY_SIMPLEX, scale, cv::Scalar(gray), width,
                cv::LINE_AA);
  }
}

}  // namespace turnscale
