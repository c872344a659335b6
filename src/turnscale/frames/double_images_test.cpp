// SPDX-License-Identifier: MIT
#include "turnscale/frames/double_images.h"

#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

constexpr double kSecondsBetween = 0.1;  // seconds
constexpr int kWidth = 320;
constexpr int kSpeed = 16;  // pixels from one image to the next

// What a camera sees that drives along a wall, at this position in pixels.
cv::Mat WallAt(double position) {
  static const cv::Mat wall = [] {
    cv::Mat all(120, 4000, CV_8UC1);
    cv::RNG random(7);
    random.fill(all, cv::RNG::NORMAL, 120, 200);
    cv::GaussianBlur(all, all, {}, 1.5);
    return all;
  }();
  return wall(cv::Rect(cvRound(position), 0, kWidth, wall.rows)).clone();
}

cv::Mat Mixed(const cv::Mat& now, const cv::Mat& before, double share_of_now) {
  cv::Mat mixed;
  cv::addWeighted(now, share_of_now, before, 1 - share_of_now, 0, mixed);
  return mixed;
}

std::vector<MovedPoint> PointsMovedBy(int speed) {
  std::vector<MovedPoint> points;
  for (int y = 10; y < 110; y += 10)
    for (int x = 10; x < kWidth - 10; x += 10)
      points.push_back({cv::Point2f(static_cast<float>(x + speed), static_cast<float>(y)),
                        cv::Point2f(static_cast<float>(x), static_cast<float>(y))});
  return points;
}

std::optional<FrameBlending> Found(const std::function<cv::Mat(int)>& image, int count = 60, int speed = kSpeed) {
  DoubleImages images;
  for (int i = 0; i < count; ++i) images.Add(image(i), kSecondsBetween * i, PointsMovedBy(speed));
  return images.Find();
}

// Images of two moments, from this one on.
std::function<cv::Mat(int)> Double(double share_of_now, int first = 0) {
  return [=](int i) {
    const cv::Mat now = WallAt(kSpeed * (i + 1));
    return i < first ? now : Mixed(now, WallAt(kSpeed * i), share_of_now);
  };
}

TEST(DoubleImages, TwoMomentsInEveryImage) {
  for (const double share : {0.5, 0.6, 0.7}) {
    const std::optional<FrameBlending> found = Found(Double(share));
    ASSERT_TRUE(found) << share;
    EXPECT_EQ(found->kind, FrameBlending::Kind::kImageBefore);
    EXPECT_EQ(found->from, 0);
    EXPECT_NEAR(found->to, 59 * kSecondsBetween, 1e-9);
  }
}

TEST(DoubleImages, NoiseReductionThatMixesImagesAgainAndAgain) {
  cv::Mat mean = WallAt(0);
  EXPECT_TRUE(Found([&mean](int i) {
    mean = Mixed(WallAt(kSpeed * (i + 1)), mean, 0.6);
    return mean.clone();
  }));
}

TEST(DoubleImages, MeansOfTwoFramesAtHalfTheRate) {
  constexpr int kBetweenMoments = 16;
  constexpr int kBetweenImages = 2 * kBetweenMoments;
  const auto mean = [](int i) {
    return Mixed(WallAt(kBetweenImages * (i + 1)), WallAt(kBetweenImages * (i + 1) - kBetweenMoments), 0.5);
  };
  const std::optional<FrameBlending> found = Found(mean, 60, kBetweenImages);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, FrameBlending::Kind::kHalfInterval);
  EXPECT_FALSE(Found([](int i) { return WallAt(kBetweenImages * (i + 1)); }, 60, kBetweenImages)) << "one moment";
}

TEST(DoubleImages, OnlyAPartOfTheDrive) {
  const std::optional<FrameBlending> found = Found(Double(0.5, 40));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->from, 40 * kSecondsBetween, 1e-9);
  EXPECT_FALSE(Found(Double(0.5, 50))) << "too little of it";
}

TEST(DoubleImages, NothingIsFoundInImagesOfOneMoment) {
  const auto sharp = [](int i) { return WallAt(kSpeed * (i + 1)); };
  EXPECT_FALSE(Found(sharp));
  EXPECT_FALSE(Found([&sharp](int i) {
    cv::Mat image = sharp(i);
    cv::GaussianBlur(image, image, {}, 4);
    return image;
  })) << "out of focus";
  EXPECT_FALSE(Found([](int i) {
    cv::Mat sum = cv::Mat::zeros(120, kWidth, CV_32F);
    for (int step = 0; step < kSpeed; ++step) cv::accumulate(WallAt(kSpeed * i + step), sum);
    cv::Mat image;
    sum.convertTo(image, CV_8U, 1.0 / kSpeed);
    return image;
  })) << "blurred by an exposure as long as the interval";
}

TEST(DoubleImages, NothingIsFoundInAPatternThatRepeats) {
  for (const double period : {8.0, 12.0, 16.0, 20.0, 32.0}) {
    EXPECT_FALSE(Found([period](int i) {
      cv::Mat image(120, kWidth, CV_8UC1);
      for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x)
          image.at<uchar>(y, x) = cv::saturate_cast<uchar>(120 + 80 * std::cos(2 * CV_PI * (x + kSpeed * i) / period) +
                                                           20 * std::sin(0.4 * (y + i)));
      return image;
    })) << period;
  }
}

TEST(DoubleImages, TooLittleMotionOrTooFewImagesTellNothing) {
  EXPECT_FALSE(Found(Double(0.5), 15));
  EXPECT_TRUE(Found(Double(0.5), 16));
  EXPECT_FALSE(Found(Double(0.5, 45), 60)) << "15 of 60";
  EXPECT_FALSE(Found(Double(0.5), 60, 5));
  DoubleImages images;
  for (int i = 0; i < 60; ++i)
    images.Add(cv::Mat(10, 10, CV_8UC1, cv::Scalar(i)), kSecondsBetween * i, PointsMovedBy(kSpeed));
  EXPECT_FALSE(images.Find());
}

}  // namespace
}  // namespace turnscale
