// SPDX-License-Identifier: MIT
#include "turnscale/camera/lens_fit.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

constexpr int kWidth = 1280;
constexpr int kHeight = 720;

CameraModel MadeCamera(LensModel lens, double focal_length, std::array<double, 5> distortion) {
  return {{focal_length, focal_length, 650, 350}, lens, distortion, kWidth, kHeight};
}

RayOfPixel RaysOf(const CameraModel& camera) {
  return [camera](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
    const std::optional<Eigen::Vector2d> ideal = camera.Undistort(pixel);
    if (!ideal) return std::nullopt;
    return camera.pinhole.Ray(*ideal).head<2>();
  };
}

double LargestPixelError(const CameraModel& camera, const CameraModel& truth) {
  double largest = 0;
  for (double x = 0; x < kWidth; x += 40)
    for (double y = 0; y < kHeight; y += 40) {
      const Eigen::Vector2d ideal = *truth.Undistort({x, y});
      const std::optional<Eigen::Vector2d> shown = camera.Project(truth.pinhole.Ray(ideal));
      largest = std::max(largest, shown ? (*shown - Eigen::Vector2d(x, y)).norm() : HUGE_VAL);
    }
  return largest;
}

TEST(FitLens, FindsTheModelThatMadeTheRays) {
  for (const CameraModel& truth :
       {MadeCamera(LensModel::kPinhole, 900, {}), MadeCamera(LensModel::kRadialTangential, 900, {-0.28, 0.07, 0, 0, 0}),
        MadeCamera(LensModel::kEquidistant, 600, {0.02, -0.01, 0, 0, 0})}) {
    const std::optional<CameraModel> fit = FitLens(truth.pinhole, kWidth, kHeight, RaysOf(truth));
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->lens, truth.lens);
    EXPECT_LT(LargestPixelError(*fit, truth), 1e-3);
  }
}

TEST(FitLens, KeepsTangentialDistortion) {
  const CameraModel truth = MadeCamera(LensModel::kRadialTangential, 900, {-0.28, 0.07, 0.004, -0.003, 0});
  const std::optional<CameraModel> fit =
      FitLens(truth.pinhole, kWidth, kHeight, RaysOf(truth), HUGE_VAL, {0.004, -0.003});
  ASSERT_TRUE(fit);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(fit->distortion[i], truth.distortion[i], 1e-6) << i;
  EXPECT_LT(LargestPixelError(*fit, truth), 1e-3);
}

TEST(FitLens, ComesCloseWithALensThatIsNeither) {
  // Three radial terms.
  CameraModel truth = MadeCamera(LensModel::kRadialTangential, 900, {-0.32, 0.15, 0, 0, -0.04});
  const std::optional<CameraModel> fit = FitLens(truth.pinhole, kWidth, kHeight, RaysOf(truth));
  ASSERT_TRUE(fit);
  EXPECT_LT(LargestPixelError(*fit, truth), 1);
}

// Rays of a lens that folds back within the image, and something else beyond `radius`: a program that gives this
// distortion to images leaves them black there.
RayOfPixel RaysWithin(double radius, const CameraModel& truth) {
  return [=](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
    if ((pixel - Eigen::Vector2d(truth.pinhole.cx, truth.pinhole.cy)).norm() <= radius) return RaysOf(truth)(pixel);
    return 1.5 * truth.pinhole.Ray(pixel).head<2>();
  };
}

TEST(FitLens, IgnoresPixelsBeyondTheRadius) {
  constexpr double kRadius = 600;
  const CameraModel truth = MadeCamera(LensModel::kRadialTangential, 900, {-0.25, 0, 0, 0, 0});
  ASSERT_FALSE(truth.Undistort({0, kHeight - 1}));
  const auto error = [&](const CameraModel& fit) {
    double largest = 0;
    for (double x = 60; x < 550; x += 10) {
      const Eigen::Vector2d pixel = Eigen::Vector2d(truth.pinhole.cx + x, truth.pinhole.cy);
      const std::optional<Eigen::Vector2d> shown = fit.Project(truth.pinhole.Ray(*truth.Undistort(pixel)));
      largest = std::max(largest, shown ? (*shown - pixel).norm() : HUGE_VAL);
    }
    return largest;
  };
  const RayOfPixel rays = RaysWithin(kRadius, truth);
  const std::optional<CameraModel> fit = FitLens(truth.pinhole, kWidth, kHeight, rays, kRadius);
  ASSERT_TRUE(fit);
  EXPECT_LT(error(*fit), 0.3);
  const std::optional<CameraModel> whole = FitLens(truth.pinhole, kWidth, kHeight, rays);
  EXPECT_TRUE(!whole || error(*whole) > 3);
}

TEST(FitLens, RefusesTooFewPixels) {
  const CameraModel truth = MadeCamera(LensModel::kRadialTangential, 900, {-0.28, 0.07, 0, 0, 0});
  for (const double radius : {0.0, 30.0}) EXPECT_FALSE(FitLens(truth.pinhole, kWidth, kHeight, RaysOf(truth), radius));
}

TEST(FitLens, RefusesRaysThatFoldBack) {
  const Pinhole pinhole{600, 600, 640, 360};
  const RayOfPixel folding = [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector2d point = pinhole.Ray(pixel).head<2>();
    return Eigen::Vector2d(point * (1 - 0.6 * point.squaredNorm()));
  };
  EXPECT_FALSE(FitLens(pinhole, kWidth, kHeight, folding));
  EXPECT_FALSE(FitLens(pinhole, kWidth, kHeight, [](const auto&) { return std::nullopt; }));
}

}  // namespace
}  // namespace turnscale
