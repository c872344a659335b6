// SPDX-License-Identifier: MIT
#include "turnscale/frames/image_scaling.h"

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

CameraModel Camera(int width, int height) {
  CameraModel camera;
  camera.pinhole = {1700.25, 1710.5, 0.5 * width - 13, 0.5 * height + 21.75};
  camera.lens = LensModel::kRadialTangential;
  camera.distortion = {-0.2, 0.05, 1e-3, -2e-3, 0};
  camera.width = width;
  camera.height = height;
  camera.focal_sigma = 3;
  return camera;
}

double PixelWidth(const cv::Size& size, int max_width, int min_width) {
  return ImageScaling(size, {.max_width = max_width, .min_width = min_width}).pixel_width();
}

ImageScaling Reducing(const cv::Size& size, int max_width) { return {size, {.max_width = max_width, .min_width = 0}}; }

ImageScaling Enlarging(const cv::Size& size, int min_width) { return {size, {.max_width = 0, .min_width = min_width}}; }

TEST(ImageOptions, ASenselessWidthIsRefused) {
  const auto refused = [](auto change) { return RefusedField<ImageOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.max_width = -1; }), "max_width");
  EXPECT_EQ(refused([](auto& o) { o.max_width = 63; }), "max_width");
  EXPECT_EQ(refused([](auto& o) { o.min_width = -1; }), "min_width");
  EXPECT_EQ(refused([](auto& o) { o.min_width = 5000; }), "min_width");
}

TEST(ImageScaling, HalvesUntilTheWidthFits) {
  EXPECT_EQ(PixelWidth({1920, 1080}, 2048, 480), 1);
  EXPECT_EQ(PixelWidth({2048, 1536}, 2048, 480), 1);
  EXPECT_EQ(PixelWidth({2560, 1440}, 2048, 480), 2);
  EXPECT_EQ(PixelWidth({3840, 2160}, 2048, 480), 2);
  EXPECT_EQ(PixelWidth({7680, 4320}, 2048, 480), 4);
  EXPECT_EQ(PixelWidth({7680, 4320}, 0, 480), 1);
  EXPECT_EQ(PixelWidth({}, 2048, 480), 1);
  EXPECT_EQ(PixelWidth({601, 400}, 600, 480), 2) << "not enlarged again";
  EXPECT_EQ(PixelWidth({640, 1}, 100, 480), 1) << "no row would be left";
}

TEST(ImageScaling, DoublesUntilTheWidthIsEnough) {
  EXPECT_EQ(PixelWidth({480, 270}, 2048, 480), 1);
  EXPECT_EQ(PixelWidth({320, 240}, 2048, 480), 0.5);
  EXPECT_EQ(PixelWidth({160, 120}, 2048, 480), 0.25);
  EXPECT_EQ(PixelWidth({320, 240}, 2048, 0), 1);
  EXPECT_EQ(PixelWidth({320, 240}, 600, 480), 1) << "would be wider than allowed";
  EXPECT_EQ(PixelWidth({1, 1}, 0, 4096), 1.0 / 4096);
  EXPECT_EQ(PixelWidth({320, 240}, 0, 480), 0.5);
}

TEST(ImageScaling, PixelsAreMeansOfSquares) {
  cv::Mat gray(5, 7, CV_8UC1);
  for (int i = 0; i < 35; ++i) gray.at<uchar>(i / 7, i % 7) = static_cast<uchar>(4 * i);
  const cv::Mat reduced = Reducing(gray.size(), 6).Scaled(gray);
  ASSERT_EQ(reduced.size(), cv::Size(3, 2));
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 3; ++column)
      EXPECT_EQ(reduced.at<uchar>(row, column), 4 * (14 * row + 2 * column + 4)) << row << " " << column;
}

TEST(ImageScaling, ARayIsSeenAtTheSamePlace) {
  const CameraModel camera = Camera(3841, 2160);
  const ImageScaling reduction = Reducing({3841, 2160}, 1000);
  ASSERT_EQ(reduction.pixel_width(), 4);
  const CameraModel reduced = reduction.Scaled(camera);
  EXPECT_EQ(cv::Size(reduced.width, reduced.height), cv::Size(960, 540));
  const Eigen::Vector3d ray(0.3, -0.2, 1);
  const Eigen::Vector2d at = *camera.Project(ray);
  const Eigen::Vector2d reduced_at = *reduced.Project(ray);
  // Edges of pixels are at halves.
  EXPECT_NEAR((at.x() + 0.5) / 4, reduced_at.x() + 0.5, 1e-9);
  EXPECT_NEAR((at.y() + 0.5) / 4, reduced_at.y() + 0.5, 1e-9);
}

TEST(ImageScaling, ACameraComesBackAtFullSize) {
  const CameraModel camera = Camera(3841, 2161);
  const ImageScaling reduction = Reducing({3841, 2161}, 2000);
  const CameraModel full = reduction.Full(reduction.Scaled(camera));
  EXPECT_EQ(full, camera);
  EXPECT_EQ(reduction.FullPlace(960), 1920.5);
}

TEST(ImageScaling, AMaskedPixelMasksItsSquare) {
  cv::Mat mask(5, 8, CV_8UC1, cv::Scalar(255));
  mask.at<uchar>(1, 2) = 0;
  mask.at<uchar>(2, 5) = 0;
  const ImageScaling reduction = Reducing(mask.size(), 4);
  const cv::Mat reduced = reduction.ScaledMask(mask);
  ASSERT_EQ(reduced.size(), cv::Size(4, 2));
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_EQ(reduced.at<uchar>(row, column) == 0, (row == 0 && column == 1) || (row == 1 && column == 2));
  const cv::Mat full = reduction.FullMask(reduced);
  ASSERT_EQ(full.size(), mask.size());
  EXPECT_EQ(cv::countNonZero(full == 0), 4 + 6) << "the last row belongs to no square and is as the one above";
  EXPECT_TRUE(reduction.FullMask({}).empty());
}

TEST(ImageScaling, EnlargedImagesShowARayAtTheSamePlace) {
  const CameraModel camera = Camera(321, 180);
  const ImageScaling enlargement = Enlarging({321, 180}, 1000);
  ASSERT_EQ(enlargement.pixel_width(), 0.25);
  const CameraModel enlarged = enlargement.Scaled(camera);
  EXPECT_EQ(cv::Size(enlarged.width, enlarged.height), cv::Size(1284, 720));
  const Eigen::Vector3d ray(0.03, -0.02, 1);
  EXPECT_NEAR(4 * (camera.Project(ray)->x() + 0.5), enlarged.Project(ray)->x() + 0.5, 1e-9);
  EXPECT_EQ(enlargement.Full(enlarged), camera);
  EXPECT_EQ(enlargement.Scaled(Camera(0, 0)).width, 0) << "unknown";

  // A slope of one level a pixel: interpolation meets it where the calibration says.
  cv::Mat gray(40, 60, CV_8UC1);
  for (int column = 0; column < gray.cols; ++column) gray.col(column) = 4 * column;
  const cv::Mat scaled = Enlarging(gray.size(), 100).Scaled(gray);
  ASSERT_EQ(scaled.size(), gray.size() * 2);
  for (int column = 10; column < 100; ++column) EXPECT_EQ(scaled.at<uchar>(40, column), 2 * column - 1) << column;
}

TEST(ImageScaling, AMaskIsEnlargedAndComesBack) {
  cv::Mat mask(5, 8, CV_8UC1, cv::Scalar(255));
  mask.at<uchar>(1, 2) = 0;
  const ImageScaling enlargement = Enlarging(mask.size(), 16);
  cv::Mat enlarged = enlargement.ScaledMask(mask);
  ASSERT_EQ(enlarged.size(), cv::Size(16, 10));
  EXPECT_EQ(cv::countNonZero(enlarged == 0), 4);
  enlarged.at<uchar>(9, 15) = 0;
  const cv::Mat full = enlargement.FullMask(enlarged);
  ASSERT_EQ(full.size(), mask.size());
  EXPECT_EQ(cv::countNonZero(full == 0), 2);
  EXPECT_EQ(full.at<uchar>(4, 7), 0);
}

TEST(ImageScaling, ImagesOfTheRightSizeStay) {
  const cv::Mat gray(4, 6, CV_8UC1, cv::Scalar(7));
  const ImageScaling scaling = Reducing(gray.size(), 6);
  EXPECT_EQ(scaling.Scaled(gray).data, gray.data);
  EXPECT_EQ(scaling.FullMask(gray).data, gray.data);
  EXPECT_EQ(scaling.Scaled(Camera(6, 4)), Camera(6, 4));
  EXPECT_EQ(scaling.Full(cv::Size(3, 2)), cv::Size(3, 2));
}

}  // namespace
}  // namespace turnscale
