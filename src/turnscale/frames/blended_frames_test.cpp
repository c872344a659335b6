// SPDX-License-Identifier: MIT
#include "turnscale/frames/blended_frames.h"

#include <cmath>
#include <functional>
#include <optional>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

constexpr double kImagesPerSecond = 10;  // images per second

// A wall with fine detail that a camera drives along; `position` in pixels.
class Wall {
 public:
  Wall() : all_(120, 8000, CV_8UC1) {
    cv::RNG random(7);
    random.fill(all_, cv::RNG::NORMAL, 120, 120);
    cv::GaussianBlur(all_, all_, {}, 1.2);
  }
  cv::Mat At(double position) const { return all_(cv::Rect(cvRound(position), 0, 320, all_.rows)).clone(); }

 private:
  cv::Mat all_;
};

// Images of a camera that moves by `speed` pixels from one to the next.
std::function<cv::Mat(int)> Driving(double speed = 12) {
  return [wall = Wall(), speed](int i) { return wall.At(speed * i); };
}

// The same video at another rate: `step` of its images for each.
std::function<cv::Mat(int)> Converted(const std::function<cv::Mat(int)>& video, double step) {
  return [=](int i) {
    const int first = static_cast<int>(std::floor(step * i + 1e-9));
    const double share = std::max(step * i - first, 0.0);
    cv::Mat blend;
    cv::addWeighted(video(first), 1 - share, video(first + 1), share, 0, blend);
    return blend;
  };
}

std::optional<FrameBlending> Blending(const std::function<cv::Mat(int)>& image, int count = 130) {
  BlendedFrames frames;
  for (int i = 0; i < count; ++i) frames.Add(image(i), i / kImagesPerSecond);
  return frames.Find();
}

TEST(BlendedFrames, ConversionShowsByItsRhythm) {
  struct Conversion {
    double from;
    double to;
    double period;  // images after which the weights are the same
  };
  for (const Conversion& c : {Conversion{10, 8, 4}, {10, 12, 6}, {10, 15, 3}, {30, 25, 5}, {30, 20, 2}, {30, 60, 2}}) {
    const std::optional<FrameBlending> found = Blending(Converted(Driving(), c.from / c.to));
    ASSERT_TRUE(found) << c.from << " to " << c.to;
    EXPECT_NEAR(found->period, c.period, 0.1);
    EXPECT_EQ(found->from, 1 / kImagesPerSecond);
    EXPECT_EQ(found->to, 128 / kImagesPerSecond);
  }
}

TEST(BlendedFrames, NothingIsFoundInImagesAsTheCameraRecordedThem) {
  EXPECT_FALSE(Blending(Driving()));
  EXPECT_FALSE(Blending([video = Driving()](int i) { return video(i / 3); })) << "images repeated";
  EXPECT_FALSE(Blending([video = Driving()](int i) {
    cv::Mat image;
    video(i).convertTo(image, -1, i % 2 == 0 ? 1 : 0.6);
    return image;
  })) << "flicker";
  EXPECT_FALSE(Blending([video = Driving()](int i) {
    cv::Mat image;
    video(i).convertTo(image, -1, 1, i % 5 == 0 ? 150 : 0);
    return image;
  })) << "light that flashes";
  cv::RNG random(3);
  EXPECT_FALSE(Blending([&random, video = Driving()](int i) {
    cv::Mat image = video(i);
    cv::GaussianBlur(image, image, {}, random.uniform(0.3, 1.2));
    return image;
  })) << "vibration";
  EXPECT_FALSE(Blending([video = Driving()](int i) {
    cv::Mat image = video(i);
    image.colRange(i % 10 * 30, i % 10 * 30 + 20) = 20;
    return image;
  })) << "a wiper";
}

TEST(BlendedFrames, ACarThatStandsShowsNothing) {
  EXPECT_FALSE(Blending(Converted(Driving(0), 1.25)));
  const auto stops = [video = Converted(Driving(), 1.25)](int i) { return video(std::min(i, 260)); };
  const std::optional<FrameBlending> found = Blending(stops, 520);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->from, 1 / kImagesPerSecond);
  EXPECT_NEAR(found->to, 26, 4);
}

TEST(BlendedFrames, TooFewOrTooSmallImagesShowNothing) {
  EXPECT_FALSE(BlendedFrames().Find());
  EXPECT_FALSE(Blending(Converted(Driving(), 1.25), 41));
  EXPECT_TRUE(Blending(Converted(Driving(), 1.25), 42));
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(20, 200), cv::Size(900, 1)})
    EXPECT_FALSE(Blending([&](int i) { return cv::Mat(size, CV_8UC1, cv::Scalar(i % 4)); }));
}

TEST(BlendedFrames, TheWarningSaysWhatToDo) {
  EXPECT_EQ(FrameBlendingText({.from = 1, .to = 20.04, .period = 4}, "the scale may be wrong"),
            "the sharpness of the images rises and falls every 4 images (from 1.0 to 20.0 s), as in a video that was "
            "converted to another frame rate by blending: each image then shows two moments, and the scale may be "
            "wrong; use the video as the camera recorded it");
  EXPECT_EQ(FrameBlendingText({.period = 2.5}, "x").find("the sharpness of the images rises and falls every 2.5 "), 0U);
}

TEST(BlendedFrames, TheWarningOfWeightsThatDoNotChange) {
  EXPECT_EQ(
      FrameBlendingText({.from = 1, .to = 20.04, .kind = FrameBlending::Kind::kImageBefore}, "the scale may be wrong"),
      "each image seems to contain a copy of the one before (from 1.0 to 20.0 s), as blended frames or "
      "strong temporal noise reduction leave it: the scale may be wrong; use the video as the camera recorded it, "
      "and record later drives without temporal noise reduction");
  EXPECT_EQ(
      FrameBlendingText({.from = 1, .to = 20.04, .kind = FrameBlending::Kind::kHalfInterval}, "the scale may be wrong"),
      "each image seems to be the mean of two frames (from 1.0 to 20.0 s), as in a video whose frame rate was halved "
      "by blending: the scale may be wrong; use the video as the camera recorded it");
}

}  // namespace
}  // namespace turnscale
