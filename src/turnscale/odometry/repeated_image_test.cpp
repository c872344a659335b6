// SPDX-License-Identifier: MIT
#include "turnscale/odometry/repeated_image.h"

#include <random>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/refused_field.h"
#include "turnscale/features/synthetic_texture.h"

namespace turnscale {
namespace {

constexpr double kDepth = 10;
constexpr ImageTiming kUsualTiming = {.since_measured = 0.1, .interval = 0.1};
const RigidTransform kFirst{Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()};

// A textured wall straight ahead; the camera moves to the right and its image to the left.
class Wall : public testing::Test {
 protected:
  Wall() {
    map_.camera = {.pinhole = {400, 400, 160, 120}, .width = 320, .height = 240};
    map_.keyframes.push_back({0, 0, kFirst, {}, false});
    for (int row = 40; row <= 200; row += 20)
      for (int column = 40; column <= 280; column += 20) AddTrack({column + 0.3, row - 0.2});
  }

  void AddTrack(const Eigen::Vector2d& pixel) {
    FeatureTrack track;
    track.landmark = static_cast<int>(map_.landmarks.size());
    track.pixel = {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
    track.undistorted = pixel;
    map_.landmarks.push_back({kDepth * map_.camera.pinhole.Ray(pixel), true, {}});
    tracks_.push_back(track);
  }

  // The pose after a move that shifts the image by so many pixels.
  RigidTransform Moved(double pixels) const {
    return {Eigen::Quaterniond::Identity(), {-pixels * kDepth / map_.camera.pinhole.fx, 0, 0}};
  }

  // What the camera sees then, with the noise and the brightness of another compression.
  cv::Mat Seen(double pixels, double noise = 0, double gain = 1) const {
    std::mt19937 random(static_cast<unsigned>(100 * pixels) + 7);
    std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
    return MakeImage({map_.camera.width, map_.camera.height}, [&](const Eigen::Vector2d& pixel) {
      const double gray = texture_.At(pixel + Eigen::Vector2d(pixels, 0));
      return gain * gray + (noise > 0 ? normal(random) : 0.0);
    });
  }

  bool Repeated(const cv::Mat& second, double expected_pixels, const ImageTiming& timing = kUsualTiming) const {
    return IsRepeated({}, {}, map_, {Seen(0), tracks_, second, Moved(expected_pixels), timing});
  }

  Map map_;
  std::vector<FeatureTrack> tracks_;
  SyntheticTexture texture_{3};
};

TEST_F(Wall, TheSameImageOnceMoreIsRepeatedWhereMotionWasExpected) {
  EXPECT_TRUE(Repeated(Seen(0), 5));
  EXPECT_TRUE(Repeated(Seen(0), 40));
  EXPECT_TRUE(Repeated(Seen(0, 4), 5)) << "noise";
  EXPECT_TRUE(Repeated(Seen(0, 2, 0.8), 5)) << "another brightness";
  EXPECT_TRUE(Repeated(Seen(0.2), 5)) << "a stabilizer's rest";
}

TEST_F(Wall, AnImageThatMovesIsNotRepeated) {
  for (const double moved : {2.0, 5.0, 9.0}) {
    EXPECT_FALSE(Repeated(Seen(moved), 5)) << moved;
    EXPECT_FALSE(Repeated(Seen(moved, 4), 5)) << moved << " with noise";
  }
  EXPECT_FALSE(Repeated(Seen(2), 3)) << "braking";
}

TEST_F(Wall, ACarThatStandsOrCreepsHasNoRepeatedImages) {
  EXPECT_FALSE(Repeated(Seen(0, 4), 0));
  EXPECT_FALSE(Repeated(Seen(0, 4), 1.2));
}

TEST_F(Wall, WhatHasTheSamePixelsIsRepeatedWhereLittleMotionWasExpected) {
  EXPECT_TRUE(Repeated(Seen(0), 0.4));
  EXPECT_FALSE(Repeated(Seen(0), 0.1)) << "a car that stands";
  cv::Mat other = Seen(0);
  other.at<uchar>(200, 300) ^= 1;
  EXPECT_FALSE(Repeated(other, 0.4));
}

TEST_F(Wall, AtAFewImagesASecondACarMayHaveStopped) {
  constexpr ImageTiming kTwoPerSecond = {.since_measured = 0.5, .interval = 0.5};
  EXPECT_FALSE(Repeated(Seen(0, 4), 5, kTwoPerSecond));
  EXPECT_TRUE(Repeated(Seen(0), 5, kTwoPerSecond)) << "the same pixels";
}

TEST_F(Wall, AnImageThatStaysTheSameForLongIsOfACarThatStands) {
  EXPECT_TRUE(Repeated(Seen(0), 5, {.since_measured = 2.9, .interval = 0.1}));
  EXPECT_FALSE(Repeated(Seen(0), 5, {.since_measured = 3.1, .interval = 0.1}));
  EXPECT_FALSE(Repeated(Seen(0), 0.4, {.since_measured = 3.1, .interval = 0.1})) << "though all pixels are the same";
}

TEST_F(Wall, AnImageThatShowsNothingIsNotRepeated) {
  cv::Mat blurred;
  cv::GaussianBlur(Seen(0), blurred, {}, 25);
  EXPECT_FALSE(Repeated(blurred, 5));
  EXPECT_FALSE(Repeated(cv::Mat::zeros(map_.camera.height, map_.camera.width, CV_8U), 5));
}

TEST_F(Wall, FewLandmarksTellNothing) {
  tracks_.resize(19);
  EXPECT_FALSE(Repeated(Seen(0), 5));
}

TEST_F(Wall, LandmarksWithoutADepthTellNothing) {
  for (Landmark& landmark : map_.landmarks) landmark.valid = false;
  EXPECT_FALSE(Repeated(Seen(0), 5));
}

TEST(RepeatedImage, MovesByLittleAndByASmallShareOfWhatWasExpected) {
  EXPECT_TRUE(IsRepeated({}, kUsualTiming, {8, 0.25}));
  EXPECT_FALSE(IsRepeated({}, kUsualTiming, {8, 0.35})) << "the prediction is wrong";
  EXPECT_FALSE(IsRepeated({.max_motion_share = 0.1}, kUsualTiming, {2, 0.25})) << "the car has slowed down";
  EXPECT_FALSE(IsRepeated({}, kUsualTiming, {1.4, 0}));
  EXPECT_FALSE(IsRepeated({}, kUsualTiming, {}));
}

TEST(RepeatedImage, WithoutPixelsTimesDecideToo) {
  constexpr ImageMotion kStill = {.expected = 8, .seen = 0.1};
  EXPECT_TRUE(IsRepeated({}, {.since_measured = 3, .interval = 0.15}, kStill));
  EXPECT_FALSE(IsRepeated({}, {.since_measured = 3.1, .interval = 0.15}, kStill));
  EXPECT_FALSE(IsRepeated({}, {.since_measured = 3, .interval = 0.16}, kStill));
}

TEST(RepeatedImage, OptionsNameTheFieldThatMakesNoSense) {
  using Options = RepeatOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_expected_motion = 0; }), "min_expected_motion");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_motion_share = 1; }), "max_motion_share");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_motion = 0; }), "max_motion");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_seconds = -1; }), "max_seconds");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_interval = -1; }), "max_interval");
}

}  // namespace
}  // namespace turnscale
