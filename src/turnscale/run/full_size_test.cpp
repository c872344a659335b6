// SPDX-License-Identifier: MIT
#include "turnscale/run/full_size.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(AtFullSize, ConvertsWhatWasEstimatedFromReducedImages) {
  CameraModel camera;
  camera.pinhole = {1700.25, 1710.5, 1907, 1102};
  camera.width = 3841;
  camera.height = 2161;
  camera.focal_sigma = 3;
  const ImageScaling halved({camera.width, camera.height}, {.max_width = 2000, .min_width = 0});
  const FoundCamera found = AtFullSize(halved, FoundCamera{halved.Scaled(camera), 1.5, 3, true});
  EXPECT_EQ(found.camera, camera);
  EXPECT_EQ(found.centre_sigma, 3);
  const ParameterEstimate focal = AtFullSize(halved, {IntrinsicsParameter::kFocalLength, 850, 900, 4});
  EXPECT_EQ(focal.given, 1700);
  EXPECT_EQ(focal.found, 1800);
  EXPECT_EQ(focal.sigma, 8);
  const ParameterEstimate centre = AtFullSize(halved, {IntrinsicsParameter::kCentreX, 960, 970, 4});
  EXPECT_EQ(centre.given, 1920.5);
  EXPECT_EQ(centre.found, 1940.5);
  EXPECT_EQ(centre.sigma, 8);
  EXPECT_EQ(AtFullSize(halved, {IntrinsicsParameter::kDistortion, 0, 0.1, 0.02}).sigma, 0.02);
  EXPECT_EQ(AtFullSize(halved, {IntrinsicsParameter::kPixelAspect, 1, 1.3, 0.02}).found, 1.3);
}

TEST(AtFullSize, ConvertsWhatWasEstimatedFromEnlargedImages) {
  const ImageScaling enlarged({321, 180}, {.max_width = 0, .min_width = 1000});
  ASSERT_EQ(enlarged.pixel_width(), 0.25);
  EXPECT_EQ(AtFullSize(enlarged, FoundCamera{CameraModel(), 8, 3, true}).centre_sigma, 2);
}

}  // namespace
}  // namespace turnscale
