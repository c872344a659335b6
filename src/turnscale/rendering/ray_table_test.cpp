// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/rendering/frame_drawing.h"
#include "turnscale/rendering/test_scene.h"

namespace turnscale {
namespace {

TEST(RayTable, RaysProjectToTheirPixels) {
  for (const CameraModel& camera : TestCameras()) {
    const RayTable table(camera, 2);
    for (int row = 0; row < camera.height; row += 37) {
      for (int column = 0; column < camera.width; column += 41) {
        const PixelRay& pixel = table.At(row, column);
        ASSERT_TRUE(pixel.sees());
        EXPECT_NEAR(pixel.direction.norm(), 1, 1e-6);
        const Eigen::Vector2d centre(column, row);
        EXPECT_LT((*camera.Project(pixel.direction.cast<double>()) - centre).norm(), 1e-3);
        const Eigen::Vector2f offset(-0.4F, 0.3F);
        const Eigen::Vector3d inside = table.Inside(row, column, offset).cast<double>();
        EXPECT_LT((*camera.Project(inside) - centre - offset.cast<double>()).norm(), 4e-3);
      }
    }
  }
}

TEST(RayTable, APixelCoversTheAngleToTheNext) {
  const CameraModel camera = TestCameras()[0];
  const RayTable table(camera, 1);
  EXPECT_NEAR(table.At(252, 309).width, 1 / std::sqrt(camera.pinhole.fx * camera.pinhole.fy), 1e-6);
}

TEST(RayTable, IsMadeAnewForAnotherCameraOnly) {
  RayTableCache cache;
  const std::vector<CameraModel> cameras = TestCameras();
  const auto first = cache.Get(cameras[0], 2);
  EXPECT_EQ(first, cache.Get(cameras[0], 1));
  EXPECT_NE(first, cache.Get(cameras[1], 1));
  CameraModel moved = cameras[0];
  moved.pinhole.cx += 1;
  EXPECT_NE(first, cache.Get(moved, 1));
}

TEST(RayTable, NeedsAnImageSize) { EXPECT_THROW(RayTable(CameraModel(), 1), InternalError); }

}  // namespace
}  // namespace turnscale
