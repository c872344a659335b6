// SPDX-License-Identifier: MIT
#include "turnscale/calibration/camera_axes.h"

#include <utility>

#include <gtest/gtest.h>

#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kTiltedAside = RotationFromYawPitchRoll({20 * kDeg, 15 * kDeg, -10 * kDeg});

// `side` is -1 for a body whose axes point forward, left and up, 1 for forward, right and down.
Trajectory InBodyAxes(Trajectory path, int side) {
  Eigen::Matrix3d camera_from_body;
  camera_from_body << 0, side, 0, 0, 0, side, 1, 0, 0;
  for (StampedPose& pose : path) {
    pose.world_from_camera.rotation = pose.world_from_camera.rotation * Eigen::Quaterniond(camera_from_body);
  }
  return path;
}

TEST(AxisConvention, TellsCamerasFromBodies) {
  const Trajectory camera = TestPath(TestRoute({1, -1}), {1, 0}, kTiltedAside);
  EXPECT_EQ(FindAxisConvention(StepsAlong(camera)), AxisConvention::kCamera);
  EXPECT_EQ(FindAxisConvention(StepsAlong(InBodyAxes(camera, -1))), AxisConvention::kForwardLeftUp);
  EXPECT_EQ(FindAxisConvention(StepsAlong(InBodyAxes(camera, 1))), AxisConvention::kForwardLeftUp);
}

TEST(AxisConvention, ACameraThatLooksSidewaysIsOne) {
  const Eigen::Quaterniond sideways = RotationFromYawPitchRoll({80 * kDeg, 0, 0});
  EXPECT_EQ(FindAxisConvention(StepsAlong(TestPath(TestRoute({1}), {1, 0}, sideways))), AxisConvention::kCamera);
}

TEST(AxisConvention, ConvertedPathsCalibrateAlike) {
  const Trajectory camera = TestPath(TestRoute({1, -1}), {1, 0}, kTiltedAside);
  for (const auto& [axes, side] :
       {std::pair(AxisConvention::kForwardLeftUp, -1), {AxisConvention::kForwardRightDown, 1}}) {
    const Calibration found = Calibrate(StepsAlong(InCameraAxes(InBodyAxes(camera, side), axes)));
    EXPECT_LT(DegreesBetween(found.vehicle_from_camera, kTiltedAside), 1e-6);
  }
}

TEST(AxisConvention, TheOtherBodyTurnsTheSignsOfYawAndPitch) {
  const Trajectory down = InBodyAxes(TestPath(TestRoute({1, -1}), {1, 0}, kTiltedAside), 1);
  const YawPitchRoll truth = YawPitchRollFromRotation(kTiltedAside);
  const YawPitchRoll found = Calibrate(StepsAlong(InCameraAxes(down, AxisConvention::kForwardLeftUp))).angles;
  EXPECT_NEAR(found.yaw, -truth.yaw, 1e-6 * kDeg);
  EXPECT_NEAR(found.pitch, -truth.pitch, 1e-6 * kDeg);
  EXPECT_NEAR(found.roll, truth.roll, 1e-6 * kDeg);
}

}  // namespace
}  // namespace turnscale
