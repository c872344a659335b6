// SPDX-License-Identifier: MIT
#include "turnscale/camera/radial_correction.h"

#include <gtest/gtest.h>

#include "turnscale/camera/camera_model.h"

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

}  // namespace
}  // namespace turnscale
