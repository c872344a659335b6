// SPDX-License-Identifier: MIT
#include "turnscale/camera/camera_model.h"

#include <random>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "turnscale/geometry/random_vector.h"

namespace turnscale {
namespace {

const Pinhole kPinhole{700, 690, 610, 180};

TEST(RadialCorrection, UndoesItself) {
  for (const double correction : {-0.03, -0.01, 0.0, 0.01, 0.03})
    for (const double x : {0.0, 300.0, 610.0, 1240.0})
      for (const double y : {0.0, 180.0, 375.0}) {
        const Eigen::Vector2d pixel(x, y);
        const Eigen::Vector2d corrected = CorrectRadially(kPinhole, correction, pixel);
        EXPECT_LT((UndoRadialCorrection(kPinhole, correction, corrected) - pixel).norm(), 1e-9);
      }
}

TEST(RadialCorrection, MovesOutwardsByTheCubeOfTheRadius) {
  const Eigen::Vector2d pixel(610 + 700, 180);  // one focal length right of the principal point
  EXPECT_NEAR(CorrectRadially(kPinhole, 0.01, pixel).x(), 610 + 700 * 1.01, 1e-9);
  EXPECT_NEAR(CorrectRadially(kPinhole, 0.01, {610 + 350, 180}).x(), 610 + 350 * 1.0025, 1e-9);
}

TEST(RadialCorrection, ChangesFromOneToAnother) {
  const Eigen::Vector2d ideal(900, 50);
  const Eigen::Vector2d pixel = CorrectRadially(kPinhole, 0.01, ideal);
  const Eigen::Vector2d changed = ChangeRadialCorrection(kPinhole, 0.01, -0.02, pixel);
  EXPECT_LT((changed - CorrectRadially(kPinhole, -0.02, ideal)).norm(), 1e-9);
}

TEST(RadialCorrection, OfACameraInvertsWithItsLens) {
  CameraModel camera;
  camera.pinhole = kPinhole;
  camera.lens = LensModel::kRadialTangential;
  camera.distortion = {-0.3, 0.1, 0.001, -0.0005, 0};
  camera.radial_correction = -0.012;
  const Eigen::Vector2d pixel(1000, 60);
  const std::optional<Eigen::Vector2d> ideal = camera.Undistort(pixel);
  ASSERT_TRUE(ideal.has_value());
  const std::optional<Eigen::Vector2d> back = camera.Project(7.0 * kPinhole.Ray(*ideal));
  ASSERT_TRUE(back.has_value());
  EXPECT_LT((*back - pixel).norm(), 1e-8);
}

TEST(RadialCorrection, ShowsNothingBeyondItsFold) {
  CameraModel camera;
  camera.pinhole = kPinhole;
  camera.radial_correction = -0.03;
  const double farthest = 2.0 / 3.0 / std::sqrt(3 * 0.03);
  for (const double share : {0.5, 0.9, 0.999}) {
    const Eigen::Vector3d ray = Eigen::Vector3d(0.8, -0.6, 1 / (share * farthest));
    const std::optional<Eigen::Vector2d> pixel = camera.Project(ray);
    ASSERT_TRUE(pixel) << share;
    EXPECT_LT((*camera.Undistort(*pixel) - kPinhole.Project(ray)).norm(), 1e-6) << share;
  }
  for (const double share : {1.001, 1.5, 10.0})
    EXPECT_FALSE(camera.Project({0.8, -0.6, 1 / (share * farthest)})) << share;
  camera.radial_correction = 0.03;
  EXPECT_TRUE(camera.Project({0.8, -0.6, 1 / (10 * farthest)}));
}

CameraModel Camera(LensModel lens, std::array<double, 5> distortion, double focal_length = 458.654) {
  CameraModel camera;
  camera.pinhole = {focal_length, 0.997 * focal_length, 367.215, 248.375};
  camera.lens = lens;
  camera.distortion = distortion;
  camera.width = 752;
  camera.height = 480;
  return camera;
}

// EuRoC's lens, one with all five coefficients, KITTI's raw lens, and two fisheyes.
std::vector<CameraModel> Cameras() {
  return {
      Camera(LensModel::kPinhole, {}),
      Camera(LensModel::kRadialTangential, {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0}),
      Camera(LensModel::kRadialTangential, {-0.3728755, 0.2037299, 0.002219027, 0.001383707, -0.07233722}, 984.2439),
      Camera(LensModel::kRadialTangential, {0.12, -0.21, -0.004, 0.003, 0.05}, 800),
      Camera(LensModel::kEquidistant, {-0.0034, 0.00071, -0.0020, 0.00020, 0}),
      Camera(LensModel::kEquidistant, {0, 0, 0, 0, 0})};
}

TEST(UndistortPoint, InvertsTheLensWithItsDerivative) {
  for (const CameraModel& camera : Cameras())
    for (const Eigen::Vector2d& distorted :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.3, -0.2), Eigen::Vector2d(0, 0.25)}) {
      const std::optional<UndistortedPoint> ideal = UndistortPoint(camera, distorted);
      ASSERT_TRUE(ideal);
      const Pinhole& pinhole = camera.pinhole;
      const Eigen::Vector2d pixel = pinhole.Project(distorted.homogeneous());
      EXPECT_LT((pinhole.Project(ideal->point.homogeneous()) - *camera.Undistort(pixel)).norm(), 1e-9);
      for (int i = 0; i < 2; ++i) {
        const Eigen::Vector2d h = 1e-6 * Eigen::Vector2d::Unit(i);
        const Eigen::Vector2d numeric =
            (UndistortPoint(camera, distorted + h)->point - UndistortPoint(camera, distorted - h)->point) / 2e-6;
        EXPECT_LT((ideal->jacobian.col(i) - numeric).norm(), 1e-8);
      }
    }
}

cv::Matx33d MatrixOf(const Pinhole& pinhole) { return {pinhole.fx, 0, pinhole.cx, 0, pinhole.fy, pinhole.cy, 0, 0, 1}; }

Eigen::Vector2d OpenCvProjection(const CameraModel& camera, const Eigen::Vector3d& x) {
  const std::vector<cv::Point3d> points = {{x.x(), x.y(), x.z()}};
  std::vector<cv::Point2d> pixels;
  const auto& k = camera.distortion;
  const cv::Vec3d zero(0, 0, 0);
  if (camera.lens == LensModel::kEquidistant) {
    cv::fisheye::projectPoints(points, pixels, zero, zero, MatrixOf(camera.pinhole), cv::Vec4d(k[0], k[1], k[2], k[3]));
  } else {
    cv::projectPoints(points, zero, zero, MatrixOf(camera.pinhole), cv::Mat(std::vector<double>(k.begin(), k.end())),
                      pixels);
  }
  return {pixels[0].x, pixels[0].y};
}

TEST(CameraModel, ProjectAgreesWithOpenCv) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> across(-0.8, 0.8);
  std::uniform_real_distribution<double> depth(0.5, 20.0);
  for (const CameraModel& camera : Cameras()) {
    for (int i = 0; i < 200; ++i) {
      const double z = depth(random);
      const Eigen::Vector3d x = z * DrawVector<2>([&] { return across(random); }).homogeneous();
      const std::optional<Eigen::Vector2d> pixel = camera.Project(x);
      ASSERT_TRUE(pixel.has_value());
      EXPECT_LT((*pixel - OpenCvProjection(camera, x)).norm(), 1e-9);
    }
  }
}

TEST(CameraModel, UndistortInvertsProjectOverTheWholeImage) {
  for (const CameraModel& camera : Cameras()) {
    for (int v = 0; v < camera.height; v += 40) {
      for (int u = 0; u < camera.width; u += 40) {
        const Eigen::Vector2d shown(u + 0.3, v + 0.7);
        const std::optional<Eigen::Vector2d> ideal = camera.Undistort(shown);
        ASSERT_TRUE(ideal.has_value()) << shown.transpose();
        const std::optional<Eigen::Vector2d> back = camera.Project(camera.pinhole.Ray(*ideal));
        ASSERT_TRUE(back.has_value()) << shown.transpose();
        EXPECT_LT((*back - shown).norm(), 1e-9) << shown.transpose();
      }
    }
  }
}

TEST(CameraModel, RadialTangentialJacobianAgreesWithOpenCv) {
  const std::array<double, 5> k = {-0.28, 0.07, 0.0019, -0.0013, 0.004};
  std::mt19937 random(12);
  std::uniform_real_distribution<double> across(-0.7, 0.7);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d x = DrawVector<2>([&] { return across(random); });
    std::vector<cv::Point2d> pixels;
    cv::Mat jacobian;
    cv::projectPoints(std::vector<cv::Point3d>{{x.x(), x.y(), 1}}, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0),
                      cv::Matx33d::eye(), cv::Mat(std::vector<double>(k.begin(), k.end())), pixels, jacobian);
    const DistortedPoint distorted = DistortRadialTangential(k, x);
    // OpenCV's columns: rotation (3), translation (3), ...; at z = 1 the translation's x and y move the point itself.
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 2; ++column) {
        EXPECT_NEAR(distorted.jacobian(row, column), jacobian.at<double>(row, 3 + column), 1e-12);
      }
    }
  }
}

TEST(CameraModel, PinholeUndistortsNothing) {
  const Eigen::Vector2d pixel(12.25, -3.5);
  EXPECT_EQ(*Camera(LensModel::kPinhole, {}).Undistort(pixel), pixel);
}

// Slopes whose falling terms alone tell that the model rises, and others, as the steps of RisesUpTo find them.
TEST(CameraModel, RisesAsItsSlopeDoes) {
  for (const double k1 : {-0.5, -0.3, 0.0, 0.2})
    for (const double k2 : {-0.2, 0.0, 0.1, 0.9})
      for (const double k3 : {-0.1, 0.0, 0.3})
        for (double radius = 0; radius < 2; radius += 0.05) {
          bool rises = true;
          for (int i = 1; i <= 1000; ++i) {
            const double u = radius * radius * i / 1000;
            rises = rises && 1 + u * (3 * k1 + u * (5 * k2 + u * 7 * k3)) > 0;
          }
          EXPECT_EQ(RadialRisesUpTo({k1, k2, 0, 0, k3}, radius), rises)
              << k1 << ' ' << k2 << ' ' << k3 << ' ' << radius;
        }
}

TEST(CameraModel, NothingBehindTheCameraOrBeyondTheFold) {
  for (const CameraModel& camera : Cameras()) {
    EXPECT_FALSE(camera.Project({0, 0, -1}).has_value());
    EXPECT_FALSE(camera.Undistort({std::nan(""), 1}).has_value());
  }
  // r (1 - 0.5 r^2) rises to r = sqrt(2/3) and shows nothing beyond 0.544.
  const CameraModel strong = Camera(LensModel::kRadialTangential, {-0.5, 0, 0, 0, 0});
  const double fold = std::sqrt(2.0 / 3.0);
  EXPECT_TRUE(strong.Project({fold * 0.99, 0, 1}).has_value());
  EXPECT_FALSE(strong.Project({fold * 1.01, 0, 1}).has_value());
  const auto at = [&](double shown) {
    return Eigen::Vector2d(strong.pinhole.cx + strong.pinhole.fx * shown, strong.pinhole.cy);
  };
  EXPECT_TRUE(strong.Undistort(at(0.543)).has_value());
  EXPECT_FALSE(strong.Undistort(at(0.55)).has_value());
  // A fisheye sees sideways, but no pinhole image shows that ray.
  const CameraModel fisheye = Camera(LensModel::kEquidistant, {});
  EXPECT_TRUE(fisheye.Project({1, 0, -0.01}).has_value());
  EXPECT_FALSE(fisheye.Undistort({fisheye.pinhole.cx + fisheye.pinhole.fx * 1.6, fisheye.pinhole.cy}).has_value());
}

}  // namespace
}  // namespace turnscale
