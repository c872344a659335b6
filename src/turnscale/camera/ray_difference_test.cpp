// SPDX-License-Identifier: MIT
#include "turnscale/camera/ray_difference.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

constexpr int kImageWidth = 1281;
constexpr int kImageHeight = 721;

CameraModel PinholeCamera(double focal_length) {
  return {.pinhole = {focal_length, focal_length, 640, 360}, .width = kImageWidth, .height = kImageHeight};
}

TEST(LargestRayDifference, IsThatOfTheCornersForAnotherFocalLength) {
  const CameraModel camera = PinholeCamera(800);
  const auto same = LargestRayDifference(camera, camera, kImageWidth, kImageHeight);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->distance, 0);
  EXPECT_LT(same->angle, 1e-12);

  const double corner = std::hypot(640, 360);
  const auto largest = LargestRayDifference(camera, PinholeCamera(1000), kImageWidth, kImageHeight);
  ASSERT_TRUE(largest);
  EXPECT_NEAR(largest->distance, corner / 800 - corner / 1000, 1e-12);
  EXPECT_NEAR(largest->angle, std::atan(corner / 800) - std::atan(corner / 1000), 1e-9);
}

TEST(LargestRayDifference, IsWithinARadius) {
  const auto within = LargestRayDifference(PinholeCamera(800), PinholeCamera(1000), kImageWidth, kImageHeight, 100);
  ASSERT_TRUE(within);
  EXPECT_NEAR(within->distance, 100 / 800.0 - 100 / 1000.0, 1e-12);
}

TEST(LargestRayDifference, IsNoneWhereACameraHasNoRay) {
  const CameraModel camera = PinholeCamera(800);
  CameraModel folded = camera;
  folded.lens = LensModel::kRadialTangential;
  folded.distortion[0] = -0.6;
  EXPECT_FALSE(LargestRayDifference(camera, folded, kImageWidth, kImageHeight));
  EXPECT_TRUE(LargestRayDifference(camera, folded, kImageWidth, kImageHeight, 100));
}

}  // namespace
}  // namespace turnscale
