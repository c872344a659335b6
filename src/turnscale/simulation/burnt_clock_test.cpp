// SPDX-License-Identifier: MIT
#include "turnscale/simulation/burnt_clock.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

cv::Mat ImageAt(double seconds) {
  cv::Mat image(270, 480, CV_8UC1, cv::Scalar(128));
  BurnClock(seconds, image);
  return image;
}

bool Same(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0; }

TEST(BurntClock, CountsTheSecondsOfTheDrive) {
  EXPECT_EQ(ClockText(0), "2026-05-17 09:41:30");
  EXPECT_EQ(ClockText(29.99), "2026-05-17 09:41:59");
  EXPECT_EQ(ClockText(30), "2026-05-17 09:42:00");
  EXPECT_EQ(ClockText(1800), "2026-05-17 10:11:30");
}

TEST(BurntClock, ChangesOncePerSecondInTheLastDigitOnly) {
  EXPECT_TRUE(Same(ImageAt(3.0), ImageAt(3.97)));
  const cv::Mat changed = ImageAt(3) != ImageAt(4);
  const int pixels = cv::countNonZero(changed);
  EXPECT_GT(pixels, 10);
  EXPECT_LT(pixels, 400);
}

TEST(BurntClock, IsReadableOnAnyGroundAndLeavesTheRest) {
  const cv::Mat image = ImageAt(0);
  double darkest = 0;
  double brightest = 0;
  cv::minMaxLoc(image, &darkest, &brightest);
  EXPECT_EQ(darkest, 0);
  EXPECT_EQ(brightest, 255);
  EXPECT_EQ(cv::countNonZero(image.rowRange(40, 270) != 128), 0);
  EXPECT_EQ(cv::countNonZero(image.colRange(240, 480) != 128), 0);
}

}  // namespace
}  // namespace turnscale
