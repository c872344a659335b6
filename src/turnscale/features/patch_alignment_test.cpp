// SPDX-License-Identifier: MIT
#include "turnscale/features/patch_alignment.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/features/corners.h"
#include "turnscale/features/synthetic_texture.h"

namespace turnscale {
namespace {

const cv::Size kViewSize(300, 240);

// What the second image shows of the first: `current_from_reference` about the centres, brightness changed.
struct View {
  SyntheticTexture texture;
  Eigen::Matrix2d reference_from_current = Eigen::Matrix2d::Identity();
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double gain = 1;
  double offset = 0;

  Eigen::Vector2d ReferenceOf(const Eigen::Vector2d& current) const {
    const Eigen::Vector2d centre(150, 120);
    return centre + reference_from_current * (current - centre - shift);
  }
  Eigen::Vector2d CurrentOf(const Eigen::Vector2d& reference) const {
    const Eigen::Vector2d centre(150, 120);
    return centre + shift + reference_from_current.inverse() * (reference - centre);
  }
  cv::Mat Reference() const {
    return MakeImage(kViewSize, [&](const Eigen::Vector2d& pixel) { return texture.At(pixel); });
  }
  cv::Mat Current() const {
    return MakeImage(kViewSize,
                     [&](const Eigen::Vector2d& pixel) { return gain * texture.At(ReferenceOf(pixel)) + offset; });
  }
};

std::vector<Eigen::Vector2d> Places() {
  std::vector<Eigen::Vector2d> places;
  for (double y = 60.3; y < 180; y += 20)
    for (double x = 70.6; x < 230; x += 20) places.emplace_back(x, y);
  return places;
}

// Where a patch holds enough to tell both coordinates; between pixels, as tracks are.
std::vector<Eigen::Vector2d> Corners(const cv::Mat& image) {
  CornerOptions options;
  options.target = 200;
  options.border = 50;
  std::vector<Eigen::Vector2d> places;
  for (const cv::Point2f& corner : DetectCorners(options, image, {}))
    places.emplace_back(corner.x + 0.3, corner.y - 0.4);
  return places;
}

// Aligns at many corners from guesses that are `guess_error` off; all that is found has to be right.
void ExpectFound(const View& view, const Eigen::Vector2d& guess_error) {
  const cv::Mat reference = view.Reference();
  const cv::Mat current = view.Current();
  const std::vector<Eigen::Vector2d> places = Corners(reference);
  ASSERT_GT(places.size(), 30U);
  int found = 0;
  double squared = 0;
  for (const Eigen::Vector2d& place : places) {
    const Eigen::Vector2d truth = view.CurrentOf(place);
    const auto pixel = AlignPatch({}, reference, place, view.reference_from_current, current, truth + guess_error);
    if (!pixel) continue;
    ++found;
    const double error = (*pixel - truth).norm();
    EXPECT_LT(error, 0.1) << place.transpose();
    squared += error * error;
  }
  EXPECT_LT(std::sqrt(squared / found), 0.03);
  EXPECT_GT(found, 0.9 * static_cast<double>(places.size()));
}

TEST(PatchAlignment, FindsAShift) {
  ExpectFound({.texture = SyntheticTexture(1), .shift = {4.37, -2.81}}, {0.9, -0.7});
}

TEST(PatchAlignment, FindsWhatHasGrownAndTurned) {
  View view{.texture = SyntheticTexture(2), .shift = {2.2, 1.6}};
  view.reference_from_current << std::cos(0.1), -std::sin(0.1), std::sin(0.1), std::cos(0.1);
  view.reference_from_current /= 1.3;
  ExpectFound(view, {-0.8, 0.8});
}

TEST(PatchAlignment, DoesNotMindTheBrightness) {
  View view{.texture = SyntheticTexture(3), .shift = {0.4, -0.3}, .gain = 0.7, .offset = 40};
  view.reference_from_current /= 1.3;
  ExpectFound(view, {0.6, 0.6});
}

TEST(PatchAlignment, DoesNotMindTheBrightnessWhereTheGuessIsRight) {
  for (const auto& [gain, offset] : {std::pair{1.0, 30.0}, {1.0, -20.0}, {0.7, 0.0}, {1.3, 10.0}}) {
    const View view{.texture = SyntheticTexture(3), .gain = gain, .offset = offset};
    const cv::Mat reference = view.Reference();
    const cv::Mat current = view.Current();
    std::size_t found = 0;
    for (const Eigen::Vector2d& place : Places())
      found += AlignPatch({}, reference, place, Eigen::Matrix2d::Identity(), current, place) ? 1 : 0;
    EXPECT_EQ(found, Places().size()) << gain << ' ' << offset;
  }
}

TEST(PatchAlignment, RefusesADifferentTexture) {
  const View view{.texture = SyntheticTexture(4)};
  const View other{.texture = SyntheticTexture(5)};
  const cv::Mat reference = view.Reference();
  const cv::Mat current = other.Current();
  int found = 0;
  for (const Eigen::Vector2d& place : Places())
    found += AlignPatch({}, reference, place, Eigen::Matrix2d::Identity(), current, place) ? 1 : 0;
  EXPECT_LE(found, 0.1 * static_cast<double>(Places().size()));
}

TEST(PatchAlignment, RefusesWhatIsFlat) {
  const cv::Mat flat(kViewSize, CV_8U, cv::Scalar(100));
  const cv::Mat textured = View{.texture = SyntheticTexture(6)}.Reference();
  const Eigen::Vector2d place(150, 120);
  EXPECT_FALSE(AlignPatch({}, flat, place, Eigen::Matrix2d::Identity(), flat, place));
  EXPECT_FALSE(AlignPatch({}, flat, place, Eigen::Matrix2d::Identity(), textured, place));
  EXPECT_FALSE(AlignPatch({}, textured, place, Eigen::Matrix2d::Identity(), flat, place));
}

TEST(PatchAlignment, RefusesToLeaveTheImages) {
  const View view{.texture = SyntheticTexture(7)};
  const cv::Mat image = view.Reference();
  const Eigen::Matrix2d same = Eigen::Matrix2d::Identity();
  const Eigen::Vector2d inside(150, 120);
  ASSERT_TRUE(AlignPatch({}, image, inside, same, image, inside));
  for (const Eigen::Vector2d& edge :
       {Eigen::Vector2d(4.9, 120), Eigen::Vector2d(294.1, 120), Eigen::Vector2d(150, 4.9), Eigen::Vector2d(150, 234.1),
        Eigen::Vector2d(-50, 1e6), Eigen::Vector2d(std::nan(""), 120)}) {
    EXPECT_FALSE(AlignPatch({}, image, edge, same, image, inside)) << edge.transpose();
    EXPECT_FALSE(AlignPatch({}, image, inside, same, image, edge)) << edge.transpose();
  }
}

TEST(PatchAlignment, RefusesToGoFar) {
  const View view{.texture = SyntheticTexture(8, 25, 60), .shift = {0, 0}};
  const cv::Mat image = view.Reference();
  PatchAlignmentOptions options;
  options.max_iterations = 30;
  int found_far = 0;
  int found_near = 0;
  for (const Eigen::Vector2d& place : Places()) {
    const Eigen::Vector2d guess = place + Eigen::Vector2d(2.4, 0);
    options.max_distance = 6;
    if (const auto pixel = AlignPatch(options, image, place, Eigen::Matrix2d::Identity(), image, guess))
      found_far += (*pixel - place).norm() < 0.05 ? 1 : 0;
    options.max_distance = 1.5;
    found_near += AlignPatch(options, image, place, Eigen::Matrix2d::Identity(), image, guess) ? 1 : 0;
  }
  EXPECT_GT(found_far, 0.7 * static_cast<double>(Places().size()));
  EXPECT_EQ(found_near, 0);
}

TEST(PatchAlignment, OptionsNameTheFieldThatMakesNoSense) {
  EXPECT_EQ(RefusedField<PatchAlignmentOptions>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<PatchAlignmentOptions>([](auto& o) { o.half_size = 1; }), "half_size");
  EXPECT_EQ(RefusedField<PatchAlignmentOptions>([](auto& o) { o.half_size = 21; }), "half_size");
  EXPECT_EQ(RefusedField<PatchAlignmentOptions>([](auto& o) { o.max_iterations = 0; }), "max_iterations");
  EXPECT_EQ(RefusedField<PatchAlignmentOptions>([](auto& o) { o.tolerance = 0; }), "tolerance");
  EXPECT_EQ(RefusedField<PatchAlignmentOptions>([](auto& o) { o.max_distance = 0; }), "max_distance");
  EXPECT_EQ(RefusedField<PatchAlignmentOptions>([](auto& o) { o.min_correlation = 1; }), "min_correlation");
}

// The same pixels, once as an image of their own and once within larger ones.
TEST(PatchAlignment, ReadsNothingBeyondTheImage) {
  const View view{SyntheticTexture(12)};
  const cv::Mat image = view.Reference();
  const auto within = [&](int gray, cv::Mat& whole) {
    cv::copyMakeBorder(image, whole, 40, 40, 40, 40, cv::BORDER_CONSTANT, cv::Scalar(gray));
    return whole(cv::Rect(40, 40, image.cols, image.rows));
  };
  cv::Mat dark_whole;
  cv::Mat bright_whole;
  const cv::Mat dark = within(0, dark_whole);
  const cv::Mat bright = within(255, bright_whole);
  int found = 0;
  for (double y = 3.4; y < 240; y += 6.1)
    for (double x = 3.7; x < 300; x += 5.3) {
      const Eigen::Vector2d pixel(x, y);
      const auto in_dark = AlignPatch({}, dark, pixel, Eigen::Matrix2d::Identity(), dark, pixel);
      EXPECT_EQ(in_dark, AlignPatch({}, bright, pixel, Eigen::Matrix2d::Identity(), bright, pixel)) << x << ' ' << y;
      found += in_dark ? 1 : 0;
    }
  EXPECT_GT(found, 500);
}

// A bright wall with little contrast: the same texture, fainter and brighter.
TEST(PatchAlignment, BrightAndFaintIsFoundLikeAnyOther) {
  View view{SyntheticTexture(13)};
  view.shift = {0.7, -0.4};
  const auto faint = [&](double dx, double dy) {
    return MakeImage(kViewSize, [&](const Eigen::Vector2d& pixel) {
      return 243 + 0.08 * (view.texture.At(pixel - Eigen::Vector2d(dx, dy)) - 128);
    });
  };
  const cv::Mat reference = faint(0, 0);
  const cv::Mat current = faint(0.7, -0.4);
  double worst = 0;
  int found = 0;
  for (const Eigen::Vector2d& place : Places()) {
    const auto pixel = AlignPatch({}, reference, place, Eigen::Matrix2d::Identity(), current, place);
    if (!pixel) continue;
    ++found;
    worst = std::max(worst, (*pixel - place - view.shift).norm());
  }
  EXPECT_GT(found, 0.9 * static_cast<double>(Places().size()));
  EXPECT_LT(worst, 0.3);
}

}  // namespace
}  // namespace turnscale
