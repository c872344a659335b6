// SPDX-License-Identifier: MIT
#include "turnscale/features/lucas_kanade.h"

#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/features/synthetic_texture.h"

namespace turnscale {
namespace {

// An image with its border, as TrackPatch takes it.
cv::Mat Bordered(const cv::Mat& image) {
  cv::Mat whole;
  cv::copyMakeBorder(image, whole, kFlowBorder, kFlowBorder, kFlowBorder, kFlowBorder, cv::BORDER_REFLECT_101);
  return whole(cv::Rect(kFlowBorder, kFlowBorder, image.cols, image.rows));
}

cv::Mat Moved(const SyntheticTexture& texture, const Eigen::Vector2d& motion) {
  return Bordered(MakeImage({160, 120}, [&](const Eigen::Vector2d& pixel) { return texture.At(pixel - motion); }));
}

TEST(LucasKanade, FindsAPatchToAFractionOfAPixel) {
  const SyntheticTexture texture(5, 10, 60);
  const cv::Mat first = Moved(texture, {0, 0});
  const Eigen::Vector2d motion(1.37, -0.81);
  const cv::Mat second = Moved(texture, motion);
  for (const int window : {5, 7, 15, 21, kMostFlowWindow}) {
    LucasKanadeOptions options;
    options.window = window;
    for (float x = 40; x <= 120; x += 16.1F) {
      const cv::Point2f point(x, 60.4F);
      const std::optional<cv::Point2f> found = TrackPatch(options, first, point, second, point);
      ASSERT_TRUE(found) << window << ' ' << x;
      EXPECT_NEAR(found->x - point.x, motion.x(), 0.06) << window << ' ' << x;
      EXPECT_NEAR(found->y - point.y, motion.y(), 0.06) << window << ' ' << x;
    }
  }
}

TEST(LucasKanade, APatchStaysWhereTheImageIsTheSame) {
  const cv::Mat image = Moved(SyntheticTexture(6), {0, 0});
  for (const cv::Point2f point : {cv::Point2f(50.3F, 40.8F), cv::Point2f(3, 2), cv::Point2f(159, 119)}) {
    const std::optional<cv::Point2f> found = TrackPatch({}, image, point, image, point);
    ASSERT_TRUE(found) << point;
    EXPECT_EQ(*found, point);
  }
}

TEST(LucasKanade, AtTheBorderWhatIsInsideDecides) {
  const SyntheticTexture texture(7, 12, 60);
  const Eigen::Vector2d motion(1.2, 0.9);
  const cv::Mat first = Moved(texture, {0, 0});
  const cv::Mat second = Moved(texture, motion);
  for (const cv::Point2f point : {cv::Point2f(3.2F, 60), cv::Point2f(80, 2.6F)}) {
    const std::optional<cv::Point2f> found = TrackPatch({}, first, point, second, point);
    ASSERT_TRUE(found);
    EXPECT_LT(std::hypot(found->x - point.x - motion.x(), found->y - point.y - motion.y()), 0.25) << point;
  }
}

TEST(LucasKanade, DoesNotDependOnWhatIsBeyondTheBorder) {
  const SyntheticTexture texture(9, 12, 60);
  const auto surrounded = [&](int gray, cv::Mat& whole) {
    const cv::Mat bordered = Moved(texture, {0, 0});
    cv::Size size;
    cv::Point offset;
    bordered.locateROI(size, offset);
    cv::Mat with_border = bordered;
    with_border.adjustROI(offset.y, offset.y, offset.x, offset.x);
    cv::copyMakeBorder(with_border, whole, 40, 40, 40, 40, cv::BORDER_CONSTANT, cv::Scalar(gray));
    return whole(cv::Rect(40 + kFlowBorder, 40 + kFlowBorder, bordered.cols, bordered.rows));
  };
  cv::Mat dark_whole;
  cv::Mat bright_whole;
  const cv::Mat dark = surrounded(0, dark_whole);
  const cv::Mat bright = surrounded(255, bright_whole);
  for (const int window : {5, 15, kMostFlowWindow}) {
    const int whole = window / 2;
    const auto half = static_cast<float>(whole);
    for (const cv::Point2f point : {cv::Point2f(0, 0), cv::Point2f(-half, 60), cv::Point2f(159 + half, 60),
                                    cv::Point2f(159, 119), cv::Point2f(80, 119 + half), cv::Point2f(80, -half)}) {
      const cv::Point2f guess = point + cv::Point2f(0.4F, -0.3F);
      EXPECT_EQ(TrackPatch({.window = window}, dark, point, dark, guess),
                TrackPatch({.window = window}, bright, point, bright, guess))
          << window << ' ' << point;
    }
  }
}

TEST(LucasKanade, FlatOrOutsideIsNotFound) {
  const cv::Mat textured = Moved(SyntheticTexture(8), {0, 0});
  const cv::Mat flat = Bordered(cv::Mat(120, 160, CV_8U, cv::Scalar(77)));
  EXPECT_FALSE(TrackPatch({}, flat, {60, 60}, textured, {60, 60}));
  EXPECT_FALSE(TrackPatch({}, textured, {-20, 60}, textured, {60, 60}));
  EXPECT_FALSE(TrackPatch({}, textured, {60, 60}, textured, {60, 140}));
  EXPECT_FALSE(TrackPatch({}, textured, {60, 60}, textured, {1e9F, 60}));
  EXPECT_FALSE(TrackPatch({}, textured, {60, 60}, textured, {NAN, 60}));
  EXPECT_FALSE(TrackPatch({}, textured, {NAN, 60}, textured, {60, 60}));
}

}  // namespace
}  // namespace turnscale
