// SPDX-License-Identifier: MIT
#include "turnscale/features/portable_features.h"

#include <gtest/gtest.h>

#include "turnscale/features/lucas_kanade.h"
#include "turnscale/features/patch_alignment.h"
#include "turnscale/features/synthetic_texture.h"

namespace turnscale {
namespace {

const cv::Size kTextureSize(150, 110);

cv::Mat WithFlowBorder(const cv::Mat& image) {
  cv::Mat whole;
  cv::copyMakeBorder(image, whole, kFlowBorder, kFlowBorder, kFlowBorder, kFlowBorder, cv::BORDER_REFLECT_101);
  return whole(cv::Rect(kFlowBorder, kFlowBorder, image.cols, image.rows));
}

cv::Mat MovedTexture(const SyntheticTexture& texture, const Eigen::Vector2d& motion, double gain) {
  return MakeImage(kTextureSize, [&](const Eigen::Vector2d& pixel) { return gain * texture.At(pixel - motion); });
}

// Everywhere in the image and beyond its edges.
std::vector<cv::Point2f> PlacesAllOver() {
  std::vector<cv::Point2f> places;
  for (float y = -9.3F; y < 120; y += 4.7F)
    for (float x = -8.6F; x < 160; x += 5.3F) places.emplace_back(x, y);
  return places;
}

TEST(PortableFeatures, OpticalFlowHasTheSameBitsWithoutVectorInstructions) {
  const SyntheticTexture texture(5, 10, 60);
  const cv::Mat first = WithFlowBorder(MovedTexture(texture, {0, 0}, 1));
  const cv::Mat second = WithFlowBorder(MovedTexture(texture, {1.37, -0.81}, 1));
  int found = 0;
  for (const int window : {5, 9, 15, 31})
    for (const cv::Point2f& place : PlacesAllOver()) {
      const cv::Point2f guess = place + cv::Point2f(0.5F, 0.25F);
      const std::optional<cv::Point2f> pixel = TrackPatch({.window = window}, first, place, second, guess);
      EXPECT_EQ(pixel, TrackPatchPortably(window, first, place, second, guess)) << window << ' ' << place;
      found += pixel ? 1 : 0;
    }
  EXPECT_GT(found, 1000);
}

TEST(PortableFeatures, AlignmentHasTheSameBitsWithoutVectorInstructions) {
  const SyntheticTexture texture(6, 10, 60);
  const cv::Mat reference = MovedTexture(texture, {0, 0}, 1);
  const cv::Mat current = MovedTexture(texture, {0.7, -0.4}, 0.9);
  Eigen::Matrix2d reference_from_current;
  reference_from_current << 0.98, 0.03, -0.02, 1.01;
  int found = 0;
  for (const cv::Point2f& place : PlacesAllOver()) {
    const Eigen::Vector2d pixel(place.x, place.y);
    const std::optional<Eigen::Vector2d> aligned =
        AlignPatch({}, reference, pixel, reference_from_current, current, pixel);
    EXPECT_EQ(aligned, AlignPatchPortably(reference, pixel, reference_from_current, current, pixel)) << place;
    found += aligned ? 1 : 0;
  }
  EXPECT_GT(found, 200);
}

}  // namespace
}  // namespace turnscale
