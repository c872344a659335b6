// SPDX-License-Identifier: MIT
#include "turnscale/io/image_reduction.h"

#include <gtest/gtest.h>

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

TEST(ImageReduction, HalvesUntilTheWidthFits) {
  EXPECT_EQ(ImageReduction({1920, 1080}, 2048).factor(), 1);
  EXPECT_EQ(ImageReduction({2048, 1536}, 2048).factor(), 1);
  EXPECT_EQ(ImageReduction({2560, 1440}, 2048).factor(), 2);
  EXPECT_EQ(ImageReduction({3840, 2160}, 2048).factor(), 2);
  EXPECT_EQ(ImageReduction({7680, 4320}, 2048).factor(), 4);
  EXPECT_EQ(ImageReduction({7680, 4320}, 0).factor(), 1);
  EXPECT_EQ(ImageReduction({}, 2048).factor(), 1);
}

TEST(ImageReduction, PixelsAreMeansOfSquares) {
  cv::Mat gray(5, 7, CV_8UC1);
  for (int i = 0; i < 35; ++i) gray.at<uchar>(i / 7, i % 7) = static_cast<uchar>(4 * i);
  const cv::Mat reduced = ImageReduction(gray.size(), 6).Reduced(gray);
  ASSERT_EQ(reduced.size(), cv::Size(3, 2));
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 3; ++column)
      EXPECT_EQ(reduced.at<uchar>(row, column), 4 * (14 * row + 2 * column + 4)) << row << " " << column;
}

TEST(ImageReduction, ARayIsSeenAtTheSamePlace) {
  const CameraModel camera = Camera(3841, 2160);
  const ImageReduction reduction({3841, 2160}, 1000);
  ASSERT_EQ(reduction.factor(), 4);
  const CameraModel reduced = reduction.Reduced(camera);
  EXPECT_EQ(cv::Size(reduced.width, reduced.height), cv::Size(960, 540));
  const Eigen::Vector3d ray(0.3, -0.2, 1);
  const Eigen::Vector2d at = *camera.Project(ray);
  const Eigen::Vector2d reduced_at = *reduced.Project(ray);
  // Edges of pixels are at halves.
  EXPECT_NEAR((at.x() + 0.5) / 4, reduced_at.x() + 0.5, 1e-9);
  EXPECT_NEAR((at.y() + 0.5) / 4, reduced_at.y() + 0.5, 1e-9);
}

TEST(ImageReduction, ACameraComesBackAtFullSize) {
  const CameraModel camera = Camera(3841, 2161);
  const ImageReduction reduction({3841, 2161}, 2000);
  const CameraModel full = reduction.Full(reduction.Reduced(camera));
  EXPECT_EQ(full, camera);
  const FoundCamera found = reduction.Full(FoundCamera{reduction.Reduced(camera), 1.5, 3, true});
  EXPECT_EQ(found.camera, camera);
  EXPECT_EQ(found.centre_sigma, 3);
  const ParameterEstimate focal = reduction.Full({IntrinsicsParameter::kFocalLength, 850, 900, 4});
  EXPECT_EQ(focal.given, 1700);
  EXPECT_EQ(focal.found, 1800);
  EXPECT_EQ(focal.sigma, 8);
  const ParameterEstimate centre = reduction.Full({IntrinsicsParameter::kCentreX, 960, 970, 4});
  EXPECT_EQ(centre.given, 1920.5);
  EXPECT_EQ(centre.found, 1940.5);
  EXPECT_EQ(centre.sigma, 8);
  EXPECT_EQ(reduction.Full({IntrinsicsParameter::kDistortion, 0, 0.1, 0.02}).sigma, 0.02);
}

TEST(ImageReduction, AMaskedPixelMasksItsSquare) {
  cv::Mat mask(5, 8, CV_8UC1, cv::Scalar(255));
  mask.at<uchar>(1, 2) = 0;
  mask.at<uchar>(2, 5) = 0;
  const ImageReduction reduction(mask.size(), 4);
  const cv::Mat reduced = reduction.ReducedMask(mask);
  ASSERT_EQ(reduced.size(), cv::Size(4, 2));
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 4; ++column)
      EXPECT_EQ(reduced.at<uchar>(row, column) == 0, (row == 0 && column == 1) || (row == 1 && column == 2));
  const cv::Mat full = reduction.FullMask(reduced);
  ASSERT_EQ(full.size(), mask.size());
  EXPECT_EQ(cv::countNonZero(full == 0), 4 + 6) << "the last row belongs to no square and is as the one above";
  EXPECT_TRUE(reduction.FullMask({}).empty());
}

TEST(ImageReduction, AFactorOfOneChangesNothing) {
  const cv::Mat gray(4, 6, CV_8UC1, cv::Scalar(7));
  const ImageReduction reduction(gray.size(), 6);
  EXPECT_EQ(reduction.Reduced(gray).data, gray.data);
  EXPECT_EQ(reduction.FullMask(gray).data, gray.data);
  EXPECT_EQ(reduction.Reduced(Camera(6, 4)), Camera(6, 4));
  EXPECT_EQ(reduction.Full(cv::Size(3, 2)), cv::Size(3, 2));
}

}  // namespace
}  // namespace turnscale
