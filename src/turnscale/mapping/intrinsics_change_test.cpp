// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_change.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/random_vector.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

CameraModel CameraWith(LensModel lens) {
  CameraModel camera;
  camera.pinhole = {718, 702, 607, 185};
  camera.lens = lens;
  if (lens != LensModel::kPinhole) camera.distortion = {-0.2, 0.05, 0.001, -0.002, 0};
  return camera;
}

constexpr LensModel kLenses[] = {LensModel::kPinhole, LensModel::kRadialTangential, LensModel::kEquidistant};

Vector ChangeOf(IntrinsicsChange::Entry entry, double value) { return value * Vector::Unit(entry); }

TEST(IntrinsicsChange, TheFocalLengthsChangeByOneFactorAndTheCentreByPixels) {
  const Pinhole given = {718, 702, 607, 185};
  Vector change = ChangeOf(IntrinsicsChange::kLogFocal, std::log(1.25));
  change[IntrinsicsChange::kCentreX] = 4;
  change[IntrinsicsChange::kCentreY] = -3;
  change.segment<3>(IntrinsicsChange::kCorrection).setConstant(0.1);
  const Pinhole changed = ChangedPinhole(given, change);
  EXPECT_NEAR(changed.fx, 1.25 * 718, 1e-9);
  EXPECT_NEAR(changed.fy, 1.25 * 702, 1e-9);
  EXPECT_EQ(changed.cx, 611);
  EXPECT_EQ(changed.cy, 182);
}

TEST(IntrinsicsChange, WithoutOneAPixelIsUndistortedAsTheCalibrationHasIt) {
  for (const LensModel lens : kLenses) {
    CameraModel camera = CameraWith(lens);
    const Eigen::Vector2d pixel(900, 40);
    const Eigen::Vector2d undistorted = *camera.Undistort(pixel);
    camera.radial_correction = 0.05;
    const std::optional<CorrectedPixel> corrected = Correct(camera, Vector::Zero(), pixel);
    ASSERT_TRUE(corrected);
    EXPECT_NEAR((corrected->pixel - undistorted).norm(), 0, 1e-9);
    EXPECT_NEAR((camera.pinhole.Project(corrected->lens_point.homogeneous()) - undistorted).norm(), 0, 1e-9);
  }
}

TEST(IntrinsicsChange, TheCorrectionMovesARayByItsTermsInTheDistortedRadius) {
  for (const LensModel lens : kLenses) {
    const CameraModel camera = CameraWith(lens);
    const Eigen::Vector2d distorted = {0.5, -0.3};
    const Eigen::Vector2d pixel = camera.pinhole.Project(distorted.homogeneous());
    Vector change = Vector::Zero();
    change.segment<3>(IntrinsicsChange::kCorrection) << 0.03, -0.02, 0.01;
    const double square = distorted.squaredNorm();
    const double share = 0.03 * square - 0.02 * square * square + 0.01 * square * square * square;
    const CorrectedPixel corrected = *Correct(camera, change, pixel);
    const Eigen::Vector2d ray = camera.pinhole.Ray(corrected.pixel).head<2>();
    EXPECT_NEAR((ray - (1 + share) * corrected.lens_point).norm(), 0, 1e-12);
    // The point itself is as the lens has it.
    EXPECT_NEAR((corrected.lens_point - UndistortPoint(camera, distorted)->point).norm(), 0, 1e-12);
  }
}

TEST(IntrinsicsChange, APlainCameraIsCorrectedAsTheMapIs) {
  CameraModel camera = CameraWith(LensModel::kPinhole);
  const Eigen::Vector2d pixel(1100, 300);
  const CorrectedPixel corrected = *Correct(camera, ChangeOf(IntrinsicsChange::kCorrection, 0.02), pixel);
  camera.radial_correction = 0.02;
  EXPECT_NEAR((corrected.pixel - *camera.Undistort(pixel)).norm(), 0, 1e-9);
}

TEST(IntrinsicsChange, AnotherPinholeSeesAnotherPointOfTheLens) {
  const CameraModel camera = CameraWith(LensModel::kRadialTangential);
  Vector change = ChangeOf(IntrinsicsChange::kLogFocal, 0.1);
  change[IntrinsicsChange::kCentreX] = 12;
  CameraModel changed = camera;
  changed.pinhole = ChangedPinhole(camera.pinhole, change);
  const Eigen::Vector2d pixel(200, 320);
  EXPECT_NEAR((Correct(camera, change, pixel)->pixel - *changed.Undistort(pixel)).norm(), 0, 1e-9);
}

TEST(IntrinsicsChange, WhereTheLensHasNoRayThereIsNoPixel) {
  CameraModel camera = CameraWith(LensModel::kRadialTangential);
  camera.distortion = {-0.4, 0, 0, 0, 0};  // folds back at a radius of 0.9, which it shows at 0.6
  const auto at_radius = [&](double radius) {
    return Eigen::Vector2d(camera.pinhole.cx + radius * camera.pinhole.fx, camera.pinhole.cy);
  };
  EXPECT_TRUE(Correct(camera, Vector::Zero(), at_radius(0.5)));
  EXPECT_FALSE(Correct(camera, Vector::Zero(), at_radius(0.7)));
  EXPECT_TRUE(Correct(camera, ChangeOf(IntrinsicsChange::kLogFocal, 0.4), at_radius(0.7))) << "a longer focal length";
}

TEST(IntrinsicsChange, TheDerivativeOfARayIsTheNumericOne) {
  constexpr double kStep = 1e-6;
  for (const LensModel lens : kLenses) {
    const CameraModel camera = CameraWith(lens);
    Vector change;
    change << 0.05, 10, -8, 0.03, -0.02, 0.01, 0.04, 0;
    const Pinhole pinhole = ChangedPinhole(camera.pinhole, change);
    const Eigen::Vector2d distorted(0.4, -0.2);
    const auto ray = [&](const Eigen::Vector2d& point) -> Eigen::Vector2d {
      return pinhole.Ray(Correct(camera, change, pinhole.Project(point.homogeneous()))->pixel).head<2>();
    };
    Eigen::Matrix2d numeric;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      numeric.col(axis) = (ray(distorted + step) - ray(distorted - step)) / (2 * kStep);
    }
    const CorrectedPixel corrected = *Correct(camera, change, pinhole.Project(distorted.homogeneous()));
    EXPECT_NEAR((corrected.jacobian - numeric).norm(), 0, 1e-7);
  }
}

TEST(IntrinsicsChange, TheDerivativeByTheIntrinsicsIsTheNumericOne) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const LensModel lens : kLenses) {
    const CameraModel camera = CameraWith(lens);
    for (int trial = 0; trial < 20; ++trial) {
      Vector at;
      at << 0.1 * normal(random), 20 * normal(random), 20 * normal(random), 0.02 * normal(random),
          0.01 * normal(random), 0.01 * normal(random), 0.1 * normal(random), 0.01 * normal(random);
      const Eigen::Vector2d ray = DrawVector<2>([&] { return normal(random); });
      const Eigen::Vector3d x(std::clamp(ray.x(), -1.5, 1.5), 0.3 * ray.y(), 3);
      const Eigen::Vector2d distorted = *camera.Project(x) + 5 * DrawVector<2>([&] { return normal(random); });
      const Eigen::Vector2d row_motion(40, -7);
      const auto residual = [&](const Vector& change) -> Eigen::Vector2d {
        return ChangedPinhole(camera.pinhole, change).Project(x) + change[IntrinsicsChange::kReadout] * row_motion -
               Correct(camera, change, distorted)->pixel;
      };
      const Pinhole pinhole = ChangedPinhole(camera.pinhole, at);
      const auto J =
          IntrinsicsJacobian(pinhole, x, pinhole.Ray(distorted).head<2>(), *Correct(camera, at, distorted), row_motion);
      for (int i = 0; i < IntrinsicsChange::kEntries; ++i) {
        const Vector h = 1e-5 * Vector::Unit(i);
        const Eigen::Vector2d numeric = (residual(at + h) - residual(at - h)) / 2e-5;
        EXPECT_NEAR((J.col(i) - numeric).norm(), 0, 1e-5 * (1 + numeric.norm())) << "entry " << i;
      }
    }
  }
}

}  // namespace
}  // namespace turnscale
