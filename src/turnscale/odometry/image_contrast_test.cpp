// SPDX-License-Identifier: MIT
#include "turnscale/odometry/image_contrast.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace turnscale {
namespace {

TEST(ImageContrast, IsThatOfPlacesAndNotOfNoise) {
  cv::Mat scene(240, 320, CV_8UC1, cv::Scalar(100));
  scene.colRange(160, 320) = 140;
  EXPECT_NEAR(ContrastOf(scene, {}), 20, 0.1);
  cv::Mat noise(scene.size(), CV_8UC1);
  cv::RNG(1).fill(noise, cv::RNG::NORMAL, 120, 10);
  EXPECT_LT(ContrastOf(noise, {}), 2);
  EXPECT_EQ(ContrastOf(cv::Mat(240, 320, CV_8UC1, cv::Scalar(7)), {}), 0);
}

TEST(ImageContrast, LeavesOutWhatTheMaskLeavesOut) {
  cv::Mat scene(240, 320, CV_8UC1, cv::Scalar(100));
  scene.rowRange(180, 240) = 0;
  cv::Mat mask(scene.size(), CV_8UC1, cv::Scalar(255));
  mask.rowRange(179, 240) = 0;
  EXPECT_GT(ContrastOf(scene, {}), 30);
  EXPECT_EQ(ContrastOf(scene, mask), 0);
}

}  // namespace
}  // namespace turnscale
