// SPDX-License-Identifier: MIT
#include "turnscale/features/corners.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>

#include "turnscale/base/refused_field.h"
#include "turnscale/features/synthetic_texture.h"

namespace turnscale {
namespace {

const cv::Size kCornerImageSize(600, 400);

CornerOptions Options() {
  CornerOptions options;
  options.target = 300;
  return options;
}

// Faint on the left, strong on the right.
cv::Mat UnevenImage() {
  const SyntheticTexture texture(1);
  return MakeImage(kCornerImageSize, [&](const Eigen::Vector2d& pixel) {
    const double contrast = pixel.x() < 300 ? 0.5 : 1.5;
    return 128 + contrast * (texture.At(pixel) - 128);
  });
}

double Distance(const cv::Point2f& a, const cv::Point2f& b) { return std::hypot(a.x - b.x, a.y - b.y); }

int CountInside(const std::vector<cv::Point2f>& corners, const cv::Rect2f& area) {
  return static_cast<int>(std::ranges::count_if(corners, [&](const cv::Point2f& c) { return area.contains(c); }));
}

TEST(Corners, FaintTextureIsNotStarvedByStrongTexture) {
  const std::vector<cv::Point2f> corners = DetectCorners(Options(), UnevenImage(), {});
  EXPECT_GT(corners.size(), 200U);
  EXPECT_LT(corners.size(), 350U);
  const int left = CountInside(corners, {0, 0, 300, 400});
  const int right = CountInside(corners, {300, 0, 300, 400});
  EXPECT_NEAR(static_cast<double>(left) / right, 1.0, 0.2);
  const float side = 2 * std::sqrt(600.0F * 400.0F / 300.0F);
  for (float y = 12; y + side <= 388; y += 10)
    for (float x = 12; x + side <= 588; x += 10)
      EXPECT_GT(CountInside(corners, {x, y, side, side}), 0) << x << ' ' << y;
}

TEST(Corners, OnePerCell) {
  const std::vector<cv::Point2f> corners = DetectCorners(Options(), UnevenImage(), {});
  const float side = std::sqrt(600.0F * 400.0F / 300.0F);
  for (float y = 0; y < 400; y += side)
    for (float x = 0; x < 600; x += side) EXPECT_LE(CountInside(corners, {x, y, side, side}), 1) << x << ' ' << y;
}

TEST(Corners, AreThoseOfTheWholeImage) {
  // They are searched in bands.
  const cv::Mat image = UnevenImage();
  CornerOptions options = Options();
  options.target = 100000;
  std::vector<cv::KeyPoint> all;
  cv::FAST(image, all, options.fast_threshold, true);
  const auto cell_of = [&](const cv::Point2f& point) {
    return std::pair(static_cast<int>(point.y / options.min_distance),
                     static_cast<int>(point.x / options.min_distance));
  };
  std::set<std::pair<int, int>> cells;
  for (const cv::KeyPoint& corner : all) {
    const cv::Rect2f inside(12, 12, 576, 376);
    if (inside.contains(corner.pt)) cells.insert(cell_of(corner.pt));
  }
  const std::vector<cv::Point2f> corners = DetectCorners(options, image, {});
  EXPECT_EQ(corners.size(), cells.size());
  for (const cv::Point2f& corner : corners) {
    EXPECT_TRUE(cells.contains(cell_of(corner)));
    EXPECT_TRUE(std::ranges::any_of(all, [&](const cv::KeyPoint& other) { return other.pt == corner; })) << corner;
  }
}

TEST(Corners, KeepAwayFromTheOnesThatAreTracked) {
  const cv::Mat image = UnevenImage();
  const std::vector<cv::Point2f> all = DetectCorners(Options(), image, {});
  const std::vector<cv::Point2f> occupied(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2));
  const std::vector<cv::Point2f> more = DetectCorners(Options(), image, occupied);
  ASSERT_FALSE(more.empty());
  for (const cv::Point2f& corner : more)
    for (const cv::Point2f& taken : occupied)
      EXPECT_GE(Distance(corner, taken), Options().min_distance - 0.5) << "half a pixel for the circle's raster";
  for (size_t i = occupied.size(); i < all.size(); ++i) {
    const bool crowded =
        std::ranges::any_of(occupied, [&](const cv::Point2f& taken) { return Distance(all[i], taken) < 13; });
    if (!crowded) {
      EXPECT_NE(std::ranges::find(more, all[i]), more.end()) << "corners that are free are still taken";
    }
  }
}

TEST(Corners, AreFoundInFog) {
  cv::Mat fog;
  UnevenImage().convertTo(fog, CV_8U, 0.2, 110);
  EXPECT_GT(DetectCorners(Options(), fog, {}).size(), 150U);
}

TEST(Corners, ADarkImageIsSearchedWithHalfTheThreshold) {
  const cv::Mat image = UnevenImage();
  CornerOptions half = Options();
  half.fast_threshold /= 2;
  EXPECT_EQ(FindCandidates(Options(), image, true).size(), FindCandidates(half, image).size());
  EXPECT_GT(FindCandidates(Options(), image, true).size(), FindCandidates(Options(), image).size());
}

TEST(Corners, AreFoundInFogBeforeABrightSky) {
  cv::Mat fog;
  UnevenImage().convertTo(fog, CV_8U, 0.1, 60);
  fog.rowRange(0, fog.rows / 2).setTo(230);
  EXPECT_GT(DetectCorners(Options(), fog, {}).size(), 75U) << "half of the cells of the lower half";
}

TEST(Corners, AreFoundOnBareWallsBesideOthers) {
  // A sixth of the image has texture that is strong, the rest is far too faint for the threshold.
  cv::Mat bare;
  UnevenImage().convertTo(bare, CV_8U, 0.12, 60);
  const cv::Rect strong(0, 0, kCornerImageSize.width, kCornerImageSize.height / 6);
  UnevenImage()(strong).copyTo(bare(strong));
  const std::vector<cv::Point2f> corners = DetectCorners(Options(), bare, {});
  EXPECT_GT(CountInside(corners, {0, 80, 600, 320}), 120) << "half of its cells";
}

TEST(Corners, StayInTheMask) {
  cv::Mat mask(kCornerImageSize, CV_8U, cv::Scalar(255));
  mask(cv::Rect(100, 100, 200, 150)).setTo(0);
  const std::vector<cv::Point2f> corners = DetectCorners(Options(), UnevenImage(), {}, mask);
  EXPECT_EQ(CountInside(corners, {100, 100, 200, 150}), 0);
  const std::vector<cv::Point2f> all = DetectCorners(Options(), UnevenImage(), {});
  EXPECT_GT(CountInside(all, {100, 100, 200, 150}), 20);
  EXPECT_GT(CountInside(corners, {320, 0, 280, 400}), 0);
  EXPECT_EQ(CountInside(corners, {320, 0, 280, 400}), CountInside(all, {320, 0, 280, 400}));
}

TEST(Corners, KeepAwayFromTheBorder) {
  CornerOptions options = Options();
  options.border = 40;
  const std::vector<cv::Point2f> corners = DetectCorners(options, UnevenImage(), {});
  ASSERT_FALSE(corners.empty());
  EXPECT_EQ(CountInside(corners, {40, 40, 520, 320}), static_cast<int>(corners.size()));
  options.border = 200;
  EXPECT_TRUE(DetectCorners(options, UnevenImage(), {}).empty()) << "the border takes the whole image";
}

TEST(Corners, NoneInAFlatImage) {
  EXPECT_TRUE(DetectCorners(Options(), cv::Mat(kCornerImageSize, CV_8U, cv::Scalar(120)), {}).empty());
}

TEST(Corners, SameImageSameCorners) {
  const cv::Mat image = UnevenImage();
  EXPECT_EQ(DetectCorners(Options(), image, {}), DetectCorners(Options(), image.clone(), {}));
}

TEST(Corners, OptionsNameTheFieldThatMakesNoSense) {
  EXPECT_EQ(RefusedField<CornerOptions>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<CornerOptions>([](auto& o) { o.target = 49; }), "target");
  EXPECT_EQ(RefusedField<CornerOptions>([](auto& o) { o.fast_threshold = 0; }), "fast_threshold");
  EXPECT_EQ(RefusedField<CornerOptions>([](auto& o) { o.fast_threshold = 256; }), "fast_threshold");
  EXPECT_EQ(RefusedField<CornerOptions>([](auto& o) { o.min_distance = std::nan(""); }), "min_distance");
  EXPECT_EQ(RefusedField<CornerOptions>([](auto& o) { o.border = 3; }), "border");
}

}  // namespace
}  // namespace turnscale
