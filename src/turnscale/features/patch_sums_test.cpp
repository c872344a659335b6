// SPDX-License-Identifier: MIT
#include "turnscale/features/patch_sums.h"

#include <array>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// Gray levels at a corner of pixels, so that nothing is rounded: in 1/32, less the template's middle.
double Shown(const PatchTemplate& patch, const cv::Mat& image, int row, int column) {
  return (image.at<uchar>(row, column) << kPatchGrayBits) - patch.middle;
}

void ExpectSumsOneByOne(int half, const cv::Mat& reference, const cv::Mat& image) {
  const int middle = reference.cols / 2;
  PatchTemplate patch;
  ASSERT_TRUE(MakeTemplate(half, reference, Eigen::Vector2d(middle, middle), Eigen::Matrix2d::Identity(), patch));
  ImageSums expected;
  TemplateSums of_template;
  for (int row = 0; row < patch.side; ++row)
    for (int column = 0; column < patch.side; ++column) {
      const int y = middle - half + row;
      const int x = middle - half + column;
      const double value = Shown(patch, reference, y, x);
      const double by_x = Shown(patch, reference, y, x + 1) - Shown(patch, reference, y, x - 1);
      const double by_y = Shown(patch, reference, y + 1, x) - Shown(patch, reference, y - 1, x);
      const double shown = Shown(patch, image, y, x);
      expected.by_x += shown * by_x;
      expected.by_y += shown * by_y;
      expected.value += shown * value;
      expected.one += shown;
      expected.gray += shown * shown;
      of_template.xx += by_x * by_x;
      of_template.xy += by_x * by_y;
      of_template.yy += by_y * by_y;
      of_template.xv += by_x * value;
      of_template.yv += by_y * value;
      of_template.vv += value * value;
      of_template.x += by_x;
      of_template.y += by_y;
      of_template.v += value;
    }
  const auto corner = static_cast<float>(middle - half);
  const ImageSums sums = SumsOf(patch, image, corner, corner);
  EXPECT_EQ(sums.by_x, expected.by_x) << half;
  EXPECT_EQ(sums.by_y, expected.by_y) << half;
  EXPECT_EQ(sums.value, expected.value) << half;
  EXPECT_EQ(sums.one, expected.one) << half;
  EXPECT_EQ(sums.gray, expected.gray) << half;
  const TemplateSums found = SumsOf(patch);
  const auto members = [](const TemplateSums& s) {
    return std::array{s.xx, s.xy, s.yy, s.xv, s.yv, s.vv, s.x, s.y, s.v};
  };
  EXPECT_EQ(members(found), members(of_template)) << half;
}

TEST(PatchSums, AreThoseOfAllPixels) {
  Random random(7);
  cv::Mat reference(60, 60, CV_8UC1);
  cv::Mat image(60, 60, CV_8UC1);
  for (cv::Mat* of : {&reference, &image})
    for (int i = 0; i < 60 * 60; ++i) of->data[i] = static_cast<uchar>(random.Uniform(0, 255.99));
  for (const int half : {2, 5, 7, 8, 20}) ExpectSumsOneByOne(half, reference, image);
}

// Between pixels, and where the patch touches the right and lower edge: as within a larger image.
TEST(PatchSums, ReadNothingBeyondTheImage) {
  Random random(8);
  cv::Mat whole(100, 100, CV_8UC1);
  for (int i = 0; i < 100 * 100; ++i) whole.data[i] = static_cast<uchar>(random.Uniform(0, 255.99));
  const cv::Mat image = whole(cv::Rect(0, 0, 60, 60)).clone();
  for (const int half : {2, 5, 8, 20}) {
    PatchTemplate patch;
    ASSERT_TRUE(MakeTemplate(half, image, Eigen::Vector2d(29.3, 30.6), Eigen::Matrix2d::Identity(), patch));
    for (const float from_edge : {0.25F, 0.5F, 1.75F, 9.3F}) {
      const float at = static_cast<float>(59 - 2 * half) - from_edge;
      const ImageSums inside = SumsOf(patch, whole, at, at);
      const ImageSums at_edge = SumsOf(patch, image, at, at);
      EXPECT_EQ(at_edge.by_x, inside.by_x) << half << ' ' << at;
      EXPECT_EQ(at_edge.by_y, inside.by_y) << half << ' ' << at;
      EXPECT_EQ(at_edge.value, inside.value) << half << ' ' << at;
      EXPECT_EQ(at_edge.one, inside.one) << half << ' ' << at;
      EXPECT_EQ(at_edge.gray, inside.gray) << half << ' ' << at;
    }
  }
}

// Black beside white, and the opposite in the image: no sum may overflow.
TEST(PatchSums, HoldTheGreatestContrast) {
  cv::Mat reference(60, 60, CV_8UC1);
  for (int row = 0; row < 60; ++row)
    for (int column = 0; column < 60; ++column)
      reference.at<uchar>(row, column) = (row / 2 + column / 2) % 2 == 0 ? uchar{0} : uchar{255};
  const cv::Mat opposite = 255 - reference;
  for (const int half : {5, 20}) {
    ExpectSumsOneByOne(half, reference, opposite);
    ExpectSumsOneByOne(half, opposite, reference);
  }
}

}  // namespace
}  // namespace turnscale
