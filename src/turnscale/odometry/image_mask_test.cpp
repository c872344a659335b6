// SPDX-License-Identifier: MIT
#include "turnscale/odometry/image_mask.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

const cv::Size kMaskedImage(1280, 640);
const Pinhole kMaskedCamera{500, 500, 320, 160};

RigidTransform Step(double yaw, double pitch, double ahead) {
  return RigidTransform{RotationFromVector({pitch, yaw, 0}), {0, 0, ahead}}.inverse();
}

ImageMask NewMask() {
  ImageMask mask;
  mask.SetSize(kMaskedImage);
  return mask;
}

int Count(const ImageMask& mask) {
  return mask.pixels().empty() ? 0 : static_cast<int>(mask.pixels().total()) - cv::countNonZero(mask.pixels());
}

TEST(LeastSceneMotion, FarPointsStandStillAhead) {
  EXPECT_NEAR(LeastSceneMotion(kMaskedCamera, Step(0, 0, 1), {100, 300}), 0, 1e-9);
}

TEST(LeastSceneMotion, WhatComesNearerCannotUndoATurnEverywhere) {
  // Turning right moves the image left; what comes nearer on the left moves left too, on the right the other way.
  const RigidTransform right = Step(0.02, 0, 1);
  EXPECT_GT(LeastSceneMotion(kMaskedCamera, right, {60, 160}), 9);
  EXPECT_LT(LeastSceneMotion(kMaskedCamera, right, {580, 160}), 0.5);
  EXPECT_GT(LeastSceneMotion(kMaskedCamera, right, {400, 310}), 8) << "the road moves down";
}

TEST(LeastSceneMotion, IsTheDistanceToTheDepthThatMovesLeast) {
  const RigidTransform step = Step(0.01, 0.012, 0.5);
  const Eigen::Vector2d pixel(420, 300);
  double least = HUGE_VAL;
  for (double depth = 0.6; depth < 500; depth *= 1.001) {
    const Eigen::Vector3d x = step * (depth * kMaskedCamera.Ray(pixel));
    if (x.z() > 0) least = std::min(least, (kMaskedCamera.Project(x) - pixel).norm());
  }
  EXPECT_NEAR(LeastSceneMotion(kMaskedCamera, step, pixel), least, 0.1);
}

TEST(ImageMask, LeavesNothingOutAtFirst) {
  const ImageMask mask = NewMask();
  EXPECT_TRUE(mask.pixels().empty());
  EXPECT_TRUE(IsKept(mask.pixels(), {3, 3}));
}

TEST(ImageMask, ACellIsLeftOutAfterRepeatedEvidence) {
  ImageMask mask = NewMask();
  for (int i = 0; i < 2; ++i) mask.Observe({{{105, 205}, true}, {{305, 105}, false}});
  EXPECT_TRUE(mask.pixels().empty()) << "two keyframes may be wrong";
  mask.Observe({{{105, 205}, true}});
  EXPECT_FALSE(IsKept(mask.pixels(), {105, 205}));
  EXPECT_TRUE(IsKept(mask.pixels(), {305, 105}));
  EXPECT_EQ(Count(mask), 400) << "one cell of 20 pixels";
}

TEST(ImageMask, WhereMostFeaturesMoveNothingIsLeftOut) {
  ImageMask mask = NewMask();
  for (int i = 0; i < 20; ++i) mask.Observe({{{105, 205}, true}, {{106, 202}, false}, {{107, 203}, false}});
  EXPECT_TRUE(mask.pixels().empty());
  mask.LeaveOut({{{105, 205}, true}, {{106, 202}, false}});
  EXPECT_TRUE(mask.pixels().empty());
}

TEST(ImageMask, WhatCertainlyStandsStillIsLeftOutAtOnce) {
  ImageMask mask = NewMask();
  mask.LeaveOut({{{105, 205}, true}});
  EXPECT_FALSE(IsKept(mask.pixels(), {105, 205}));
}

TEST(ImageMask, ACellThatMovedIsKeptBetweenOthersThatStandStill) {
  ImageMask mask = NewMask();
  mask.LeaveOut({{{105, 205}, true}, {{125, 205}, false}, {{145, 205}, true}});
  EXPECT_FALSE(IsKept(mask.pixels(), {105, 205}));
  EXPECT_TRUE(IsKept(mask.pixels(), {125, 205}));
  EXPECT_FALSE(IsKept(mask.pixels(), {145, 205}));

  ImageMask undecided = NewMask();
  undecided.LeaveOut({{{105, 205}, true}, {{125, 205}, false}, {{125, 206}, true}, {{145, 205}, true}});
  EXPECT_TRUE(IsKept(undecided.pixels(), {125, 205}));
}

TEST(ImageMask, ContraryEvidenceTakesACellBack) {
  ImageMask mask = NewMask();
  for (int i = 0; i < 50; ++i) mask.Observe({{{105, 205}, true}});
  for (int i = 0; i < 2; ++i) mask.Observe({{{105, 205}, false}});
  EXPECT_FALSE(IsKept(mask.pixels(), {105, 205}));
  for (int i = 0; i < 2; ++i) mask.Observe({{{105, 205}, false}});
  EXPECT_TRUE(mask.pixels().empty());
}

TEST(ImageMask, ACellThatNothingIsSeenInIsLookedAtAgain) {
  ImageMask mask = NewMask();
  for (int i = 0; i < 5; ++i) mask.Observe({{{105, 205}, true}});
  for (int i = 0; i < 100; ++i) mask.Observe({});
  EXPECT_FALSE(IsKept(mask.pixels(), {105, 205}));
  for (int i = 0; i < 250; ++i) mask.Observe({});
  EXPECT_TRUE(mask.pixels().empty());
}

TEST(ImageMask, APlainCellBetweenOthersThatAreLeftOutGoesWithThem) {
  ImageMask mask = NewMask();
  mask.LeaveOut({{{105, 205}, true}, {{145, 205}, true}, {{305, 205}, true}, {{345, 205}, true}});
  mask.Observe({{{325, 205}, true}});
  mask.Observe({{{325, 205}, false}});
  mask.LeaveOut({});
  EXPECT_FALSE(IsKept(mask.pixels(), {125, 205}));
  EXPECT_TRUE(IsKept(mask.pixels(), {325, 205})) << "the scene was seen there";
  EXPECT_TRUE(IsKept(mask.pixels(), {165, 205}));
}

TEST(ImageMask, CellsOfASmallImageHoldAFeature) {
  ImageMask mask;
  mask.SetSize({320, 160});
  mask.LeaveOut({{{105, 55}, true}});
  EXPECT_EQ(Count(mask), 16 * 16);
}

TEST(ImageMask, TheGivenMaskStays) {
  ImageMask mask;
  cv::Mat given(kMaskedImage, CV_8U, cv::Scalar(7));
  given.rowRange(560, 640).setTo(0);
  mask.SetGiven(given);
  mask.SetSize(kMaskedImage);
  EXPECT_EQ(Count(mask), 80 * 1280);
  for (int i = 0; i < 20; ++i) mask.Observe({{{105, 600}, false}});
  EXPECT_FALSE(IsKept(mask.pixels(), {105, 600}));
  mask.LeaveOut({{{105, 105}, true}});
  EXPECT_EQ(Count(mask), 80 * 1280 + 400);
}

TEST(ImageMask, AGivenMaskOfAnotherSizeIsRefused) {
  ImageMask mask;
  mask.SetGiven(cv::Mat(10, 20, CV_8U, cv::Scalar(255)));
  EXPECT_THROW(mask.SetSize(kMaskedImage), InputError);
}

TEST(HidesBelow, OnlyWhereMuchMoreOfTheLowerHalfIsLeftOut) {
  EXPECT_FALSE(HidesBelow({}));
  cv::Mat mask(kMaskedImage, CV_8U, cv::Scalar(255));
  mask(cv::Rect(0, 600, 400, 40)).setTo(0);
  EXPECT_FALSE(HidesBelow(mask)) << "a clock";
  mask.rowRange(500, 640).setTo(0);
  EXPECT_TRUE(HidesBelow(mask));
  cv::flip(mask, mask, 0);
  EXPECT_FALSE(HidesBelow(mask)) << "upside down";
  mask.rowRange(500, 640).setTo(0);
  EXPECT_FALSE(HidesBelow(mask)) << "on both sides";
}

TEST(StaticRegionOptions, NameTheFieldThatMakesNoSense) {
  using Options = StaticRegionOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.columns = 3; }), "columns");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_motion = 0; }), "max_motion");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_expected_motion = 1; }), "min_expected_motion");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_evidence = 0; }), "min_evidence");
}

}  // namespace
}  // namespace turnscale
