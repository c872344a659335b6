// SPDX-License-Identifier: MIT
#include "turnscale/frames/image_rotation.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

TEST(ImageRotation, TheCameraOfRotatedImagesShowsPointsWhereTheyAreInThem) {
  CameraModel camera;
  camera.pinhole = {300, 310, 155, 95};
  camera.lens = LensModel::kRadialTangential;
  camera.distortion = {-0.2, 0.05, 0.01, -0.02, 0};
  camera.width = 320;
  camera.height = 200;
  const Eigen::Vector3d point(0.2, -0.1, 1);
  const Eigen::Vector2d pixel = camera.Project(point).value();
  const auto projected = [&](int degrees, const cv::Size& size, const Eigen::Vector3d& turned) {
    const CameraModel rotated = Rotated(camera, degrees, size);
    EXPECT_EQ(cv::Size(rotated.width, rotated.height), size);
    return rotated.Project(turned).value();
  };
  const double right = camera.width - 1;
  const double bottom = camera.height - 1;
  const Eigen::Vector2d by_90 = projected(90, {200, 320}, {-point.y(), point.x(), point.z()});
  EXPECT_LT((by_90 - Eigen::Vector2d(bottom - pixel.y(), pixel.x())).norm(), 1e-9);
  const Eigen::Vector2d by_180 = projected(180, {320, 200}, {-point.x(), -point.y(), point.z()});
  EXPECT_LT((by_180 - Eigen::Vector2d(right - pixel.x(), bottom - pixel.y())).norm(), 1e-9);
  const Eigen::Vector2d by_270 = projected(270, {200, 320}, {point.y(), -point.x(), point.z()});
  EXPECT_LT((by_270 - Eigen::Vector2d(pixel.y(), right - pixel.x())).norm(), 1e-9);
}

TEST(ImageRotation, TurnsClockwise) {
  const cv::Mat image = (cv::Mat_<uchar>(2, 3) << 1, 2, 3, 4, 5, 6);
  EXPECT_EQ(Rotated(image, 90).at<uchar>(0, 1), 1) << "what was at the top left is at the top right";
  EXPECT_EQ(Rotated(image, 180).at<uchar>(1, 2), 1);
  EXPECT_EQ(Rotated(image, 270).at<uchar>(2, 0), 1);
  EXPECT_TRUE(Rotated(cv::Mat(), 90).empty());
  EXPECT_EQ(Rotated(image, 0).data, image.data);
}

TEST(ImageRotation, RowsFollowOneAnotherAsTheImagesAreTurned) {
  for (const int degrees : {0, 90, 180, 270})
    EXPECT_EQ(Rotated(ReadDirection(), degrees),
              ReadDirectionAfter([&](const cv::Mat& stored) { return Rotated(stored, degrees); }))
        << degrees;
  EXPECT_EQ(Rotated(ReadDirection(), 90), (ReadDirection{-1, 0})) << "what was below is on the left";
  EXPECT_EQ(Rotated(Rotated(ReadDirection(), 270), 90), ReadDirection());
  EXPECT_EQ(ReadDirectionAfter([](const cv::Mat& stored) { return cv::Mat(stored.t()); }), (ReadDirection{1, 0}));
}

TEST(ImageRotation, ADirectionThatTheCameraFileStatesTurnsWithTheImages) {
  CameraModel camera;
  camera.width = 320;
  camera.height = 200;
  camera.read_direction = {1, 0};
  camera.is_read_direction_stated = true;
  const CameraModel down = Rotated(camera, 90, {200, 320});
  EXPECT_EQ(down.read_direction, (ReadDirection{0, 1}));
  EXPECT_TRUE(down.is_read_direction_stated) << "though it is the usual one";
  EXPECT_EQ(Rotated(down, 90, {320, 200}).read_direction, (ReadDirection{-1, 0}));
  EXPECT_FALSE(Rotated(CameraModel{.width = 320, .height = 200}, 90, {200, 320}).is_read_direction_stated);
}

TEST(ImageRotation, OtherAnglesAreRefused) {
  EXPECT_NO_THROW(CheckRotation(270));
  for (const int degrees : {45, -90, 360}) EXPECT_THROW(CheckRotation(degrees), InputError);
}

}  // namespace
}  // namespace turnscale
