// SPDX-License-Identifier: MIT
#include "turnscale/features/keypoint_matching.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/features/synthetic_texture.h"

namespace turnscale {
namespace {

const cv::Size kSize(320, 200);

// What a camera sees that has come nearer and has moved: a pixel of it shows the first image's at this place.
Eigen::Vector2d PlaceInFirst(const Eigen::Vector2d& second) { return second / 1.7 + Eigen::Vector2d(60, 40); }

std::vector<KeypointMatch> Matched(const cv::Mat& first, const cv::Mat& second, const cv::Mat& mask = {},
                                   const KeypointOptions& options = {}) {
  return MatchKeypoints(options, DescribeKeypoints(options, first, mask), DescribeKeypoints(options, second, mask));
}

double ShareRight(const std::vector<KeypointMatch>& matches, double pixels) {
  const auto right = std::ranges::count_if(matches, [&](const KeypointMatch& match) {
    const Eigen::Vector2d first(match.first.x, match.first.y);
    return (PlaceInFirst({match.second.x, match.second.y}) - first).norm() < pixels;
  });
  return static_cast<double>(right) / static_cast<double>(matches.size());
}

cv::Mat First() {
  const SyntheticTexture texture(1);
  return MakeImage(kSize, [&](const Eigen::Vector2d& pixel) { return texture.At(pixel); });
}

cv::Mat Second() {
  const SyntheticTexture texture(1);
  return MakeImage(kSize, [&](const Eigen::Vector2d& pixel) { return texture.At(PlaceInFirst(pixel)); });
}

TEST(KeypointMatching, FindsTheSamePointsInAnotherSize) {
  const std::vector<KeypointMatch> matches = Matched(First(), Second());
  ASSERT_GT(matches.size(), 30U);
  EXPECT_GT(ShareRight(matches, 1), 0.9);
}

TEST(KeypointMatching, LargeImagesAreHalved) {
  KeypointOptions options;
  options.max_width = 200;
  const DescribedKeypoints described = DescribeKeypoints(options, First(), {});
  EXPECT_EQ(described.scale, 2);
  const std::vector<KeypointMatch> matches = Matched(First(), Second(), {}, options);
  ASSERT_GT(matches.size(), 10U);
  EXPECT_GT(ShareRight(matches, 2), 0.9);
}

TEST(KeypointMatching, LeavesOutWhatTheMaskDoes) {
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(255));
  mask.colRange(160, 320).setTo(0);
  const std::vector<KeypointMatch> matches = Matched(First(), Second(), mask);
  ASSERT_FALSE(matches.empty());
  for (const KeypointMatch& match : matches) {
    EXPECT_LT(match.first.x, 160.5F);
    EXPECT_LT(match.second.x, 160.5F);
  }
}

TEST(KeypointMatching, ImagesThatShowNothingHaveNoMatches) {
  const cv::Mat plain(kSize, CV_8UC1, cv::Scalar(128));
  EXPECT_TRUE(Matched(plain, First()).empty());
  EXPECT_TRUE(Matched(First(), plain).empty());
}

TEST(KeypointOptions, RefusesSenselessValues) {
  using Options = KeypointOptions;
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_keypoints = 0; }), "max_keypoints");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_contrast = 0; }), "min_contrast");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_width = 10; }), "max_width");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_distance_ratio = 1.1; }), "max_distance_ratio");
}

}  // namespace
}  // namespace turnscale
