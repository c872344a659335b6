// SPDX-License-Identifier: MIT
#include "turnscale/odometry/readjustment.h"

#include <limits>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/odometry/options.h"

namespace turnscale {
namespace {

constexpr LocalBundleOptions kWindow{.window = 30, .anchors = 10};
const Eigen::Quaterniond kMounted = RotationFromYawPitchRoll({0.06, -0.03, 0.02});

/// A map of a car that turns, the latest of whose keyframes are off their places.
Map MapOfTurns() {
  Map map = MakeMap(MakeCarDrive(kRightAndLeft, kStepInterval, {1.5, 0}, kMounted), {});
  for (std::size_t k = map.keyframes.size() - 20; k < map.keyframes.size(); ++k)
    map.keyframes[k].camera_from_world.translation.x() += 0.05;
  return map;
}

/// The mount that has learned from the keyframes of `map` as they come out of the adjusted window.
MountCalibration LearnedFromWindow(const Map& map, MountCalibration mount, int first) {
  WindowProblem window = MakeLocalWindow(kWindow, first, map);
  EXPECT_TRUE(AdjustWindow(kWindow, window));
  Map adjusted = map;
  for (int k = window.window.first; k < CountKeyframes(map); ++k)
    adjusted.keyframes[k].camera_from_world = window.bundle.camera_from_world[k - window.window.first];
  mount.Learn(adjusted, CountKeyframes(map) - 1);
  return mount;
}

TEST(Readjustment, TheMountLearnsFromAdjustedKeyframesWhereverItStands) {
  Map map = MapOfTurns();
  map.camera.radial_correction = 0.01;
  const int keyframes = CountKeyframes(map);
  const int first = keyframes - 20;
  // The window reaches back beyond what the mount knows, or begins after it.
  for (const int learned : {0, keyframes - 45, keyframes - 5}) {
    MountCalibration mount{VehicleOptions()};
    if (learned > 0) mount.Learn(map, learned - 1);
    const int next = mount.next_keyframe();
    const ReadjustmentWork work = WorkToReadjust(kWindow, map, mount, first);
    EXPECT_EQ(work.radial_correction, 0.01);
    EXPECT_EQ(work.first, first);
    EXPECT_EQ(work.end, keyframes);
    ASSERT_EQ(static_cast<int>(work.unlearned.size()), keyframes - next);
    const ReadjustmentResult readjusted = Readjusted(kWindow, work);
    EXPECT_EQ(readjusted.radial_correction, 0.01);
    EXPECT_EQ(readjusted.first, first);
    EXPECT_EQ(readjusted.end, keyframes);
    ASSERT_TRUE(readjusted.window);
    EXPECT_EQ(readjusted.mount.next_keyframe(), keyframes);
    const MountCalibration expected = LearnedFromWindow(map, mount, first);
    EXPECT_TRUE(expected.current().found);
    EXPECT_EQ(readjusted.mount.current().vehicle_from_camera.coeffs(), expected.current().vehicle_from_camera.coeffs());
    const Eigen::Vector3d off = readjusted.window->bundle.camera_from_world.back().translation -
                                map.keyframes.back().camera_from_world.translation;
    EXPECT_GT(off.norm(), 0.03) << "the last keyframe is back at its place";
  }
}

TEST(Readjustment, TheMountIsThatOfTheAdjustedPoses) {
  Map map = MakeMap(MakeCarDrive(kRightAndLeft, kStepInterval, {1.5, 0}, kMounted),
                    {.points_per_step = 10, .pixel_noise = 0.05});
  // Cameras are turned to the side at their places, by 1.7 degrees that the mount would show instead.
  constexpr int kFirst = 8;
  for (int k = kFirst; k < CountKeyframes(map); ++k) {
    RigidTransform& pose = map.keyframes[k].camera_from_world;
    pose = RigidTransform{RotationFromVector({0, 0.03, 0}), Eigen::Vector3d::Zero()} * pose;
  }
  const auto degrees_off = [&](const MountCalibration& mount) {
    EXPECT_TRUE(mount.current().found);
    return mount.current().vehicle_from_camera.angularDistance(kMounted) * kDegreesPerRadian;
  };
  MountCalibration as_tracked{VehicleOptions()};
  as_tracked.Learn(map, CountKeyframes(map) - 1);
  EXPECT_GT(degrees_off(as_tracked), 1);
  const ReadjustmentWork work = WorkToReadjust(kWindow, map, MountCalibration{VehicleOptions()}, kFirst);
  EXPECT_LT(degrees_off(Readjusted(kWindow, work).mount), 0.1);
}

TEST(Readjustment, AWindowOfNoNumbersIsLeftOut) {
  Map map = MapOfTurns();
  map.keyframes.back().camera_from_world.translation.x() = std::numeric_limits<double>::quiet_NaN();
  const int keyframes = CountKeyframes(map);
  const ReadjustmentResult readjusted =
      Readjusted(kWindow, WorkToReadjust(kWindow, map, MountCalibration{VehicleOptions()}, keyframes - 20));
  EXPECT_FALSE(readjusted.window);
  EXPECT_EQ(readjusted.mount.next_keyframe(), keyframes);
}

}  // namespace
}  // namespace turnscale
