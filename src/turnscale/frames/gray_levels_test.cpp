// SPDX-License-Identifier: MIT
#include "turnscale/frames/gray_levels.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace turnscale {
namespace {

// Black on the left, of that level on the right.
cv::Mat HalfOfLevel(int level) {
  cv::Mat image(4, 8, CV_16UC1, cv::Scalar(0));
  image.colRange(4, 8) = level;
  return image;
}

int BrightestOf(const cv::Mat& gray) {
  EXPECT_EQ(gray.type(), CV_8UC1);
  double brightest = 0;
  cv::minMaxLoc(gray, nullptr, &brightest);
  return static_cast<int>(brightest);
}

TEST(GrayLevels, TheRangeIsTheSmallestThatHoldsTheFirstImage) {
  const struct {
    int level;
    int bits;
  } cases[] = {{200, 8}, {255, 8}, {256, 10}, {1023, 10}, {1024, 12}, {4095, 12}, {4096, 14}, {16383, 14}};
  for (const auto& [level, bits] : cases) {
    GrayLevels levels;
    EXPECT_NEAR(BrightestOf(levels.ToGray8(HalfOfLevel(level))), level >> (bits - 8), 1) << level;
    const std::string notice = levels.TakeNotice();
    EXPECT_EQ(notice, "the 16-bit images are read as " + std::to_string(bits) +
                          " bits: the brightest level of the first one is " + std::to_string(level));
    EXPECT_EQ(levels.TakeNotice(), "") << "said once";
    levels.ToGray8(HalfOfLevel(level));
    EXPECT_EQ(levels.TakeNotice(), "");
  }
}

TEST(GrayLevels, TwelveBitsKeepTheirLevels) {
  cv::Mat ramp(1, 4096, CV_16UC1);
  for (int i = 0; i < ramp.cols; ++i) ramp.at<uint16_t>(i) = static_cast<uint16_t>(i);
  const cv::Mat gray = GrayLevels().ToGray8(ramp);
  for (int i = 0; i < ramp.cols; ++i) ASSERT_NEAR(gray.at<uint8_t>(i), std::min(i / 16.0, 255.0), 0.5) << i;
}

TEST(GrayLevels, SixteenBitsAreDividedBy256InSilence) {
  GrayLevels levels;
  EXPECT_EQ(BrightestOf(levels.ToGray8(HalfOfLevel(16384))), 64);
  EXPECT_EQ(BrightestOf(levels.ToGray8(HalfOfLevel(512))), 2) << "dark images later do not narrow the range";
  EXPECT_EQ(levels.TakeNotice(), "");
}

TEST(GrayLevels, ABrighterImageWidensTheRange) {
  GrayLevels levels;
  levels.ToGray8(HalfOfLevel(900));
  levels.TakeNotice();
  EXPECT_EQ(BrightestOf(levels.ToGray8(HalfOfLevel(3200))), 200);
  EXPECT_EQ(
      levels.TakeNotice(),
      "the levels of the 16-bit images exceed 10 bits from here on, up to 3200: they are read as 12 bits; tracking "
      "may suffer at this image");
  EXPECT_EQ(BrightestOf(levels.ToGray8(HalfOfLevel(800))), 50) << "for good";
}

TEST(GrayLevels, ABlackImageTellsNothing) {
  GrayLevels levels;
  EXPECT_EQ(BrightestOf(levels.ToGray8(HalfOfLevel(0))), 0);
  EXPECT_EQ(levels.TakeNotice(), "");
  EXPECT_EQ(BrightestOf(levels.ToGray8(HalfOfLevel(3200))), 200);
}

TEST(GrayLevels, EightBitsStayAsTheyAre) {
  GrayLevels levels;
  EXPECT_EQ(BrightestOf(levels.ToGray8(cv::Mat(4, 8, CV_8UC1, cv::Scalar(3)))), 3);
  EXPECT_EQ(BrightestOf(levels.ToGray8(cv::Mat(4, 8, CV_8UC3, cv::Scalar(3, 3, 3)))), 3);
  EXPECT_TRUE(levels.ToGray8(cv::Mat(4, 8, CV_32FC1, cv::Scalar(3))).empty());
  EXPECT_EQ(levels.TakeNotice(), "");
}

}  // namespace
}  // namespace turnscale
