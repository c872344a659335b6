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

cv::Mat First() {
  const SyntheticTexture texture(1);
  return MakeImage(kSize, [&](const Eigen::Vector2d& pixel) { return texture.At(pixel); });
}

cv::Mat Second() {
  const SyntheticTexture texture(1);
  return MakeImage(kSize, [&](const Eigen::Vector2d& pixel) { return texture.At(PlaceInFirst(pixel)); });
}

TEST(KeypointMatching, FindsTheSamePointsInAnotherSize) {
  const std::vector<KeypointMatch> matches = MatchKeypoints({}, First(), Second(), {});
  ASSERT_GT(matches.size(), 30U);
  const auto right = std::ranges::count_if(matches, [](const KeypointMatch& match) {
    return (PlaceInFirst({match.second.x, match.second.y}) - Eigen::Vector2d(match.first.x, match.first.y)).norm() < 2;
  });
  EXPECT_GT(right, 0.9 * static_cast<double>(matches.size()));
}

TEST(KeypointMatching, LeavesOutWhatTheMaskDoes) {
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(255));
  mask.colRange(160, 320).setTo(0);
  const std::vector<KeypointMatch> matches = MatchKeypoints({}, First(), Second(), mask);
  ASSERT_FALSE(matches.empty());
  for (const KeypointMatch& match : matches) {
    EXPECT_LT(match.first.x, 160.5F);
    EXPECT_LT(match.second.x, 160.5F);
  }
}

TEST(KeypointMatching, ImagesThatShowNothingHaveNoMatches) {
  const cv::Mat plain(kSize, CV_8UC1, cv::Scalar(128));
  EXPECT_TRUE(MatchKeypoints({}, plain, First(), {}).empty());
  EXPECT_TRUE(MatchKeypoints({}, First(), plain, {}).empty());
}

TEST(KeypointOptions, RefusesSenselessValues) {
  using Options = KeypointOptions;
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_keypoints = 0; }), "max_keypoints");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_contrast = 0; }), "min_contrast");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_distance_ratio = 1.1; }), "max_distance_ratio");
}

}  // namespace
}  // namespace turnscale
