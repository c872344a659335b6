// SPDX-License-Identifier: MIT
#include "turnscale/calibration/axis_convention.h"

#include <gtest/gtest.h>

#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/step_gatherer.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kTilted = RotationFromYawPitchRoll({20 * kDeg, 15 * kDeg, -10 * kDeg});

Trajectory InVehicleAxes(Trajectory path) {
  Eigen::Matrix3d camera_from_vehicle;
  camera_from_vehicle << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  for (StampedPose& pose : path) {
    pose.world_from_camera.rotation = pose.world_from_camera.rotation * Eigen::Quaterniond(camera_from_vehicle);
  }
  return path;
}

TEST(AxisConvention, TellsCamerasFromVehicles) {
  const Trajectory camera = TestPath(TestRoute({1, -1}), {1, 0}, kTilted);
  EXPECT_EQ(FindAxisConvention(StepsAlong(camera)), AxisConvention::kCamera);
  EXPECT_EQ(FindAxisConvention(StepsAlong(InVehicleAxes(camera))), AxisConvention::kVehicle);
}

TEST(AxisConvention, ACameraThatLooksSidewaysIsOne) {
  const Eigen::Quaterniond sideways = RotationFromYawPitchRoll({80 * kDeg, 0, 0});
  EXPECT_EQ(FindAxisConvention(StepsAlong(TestPath(TestRoute({1}), {1, 0}, sideways))), AxisConvention::kCamera);
}

TEST(AxisConvention, ConvertedPathsCalibrateAlike) {
  const Trajectory camera = TestPath(TestRoute({1, -1}), {1, 0}, kTilted);
  const Calibration found = Calibrate(StepsAlong(InCameraAxes(InVehicleAxes(camera))));
  EXPECT_LT(DegreesBetween(found.vehicle_from_camera, kTilted), 0.01);
}

}  // namespace
}  // namespace turnscale
