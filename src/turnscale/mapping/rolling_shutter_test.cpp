// SPDX-License-Identifier: MIT
#include "turnscale/mapping/rolling_shutter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

constexpr double kReadout = 0.02;  // seconds

// Through a turn, with keyframes 0.1 s apart.
Map TurningMap(double readout) {
  const CarDrive drive =
      MakeCarDrive({{10, 0.8, 0}, {20, 0.8, 0.05}, {10, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  Map map = MakeMap(drive, {.points_per_step = 10, .pixel_noise = 0, .readout = readout});
  map.camera.readout = readout;
  return map;
}

// Root mean square distance of the pixels of keyframes `first`...`last` from where the landmarks project.
double RmsError(const Map& map, int first, int last) {
  double sum = 0;
  int count = 0;
  for (int k = first; k <= last; ++k)
    for (const KeyframeObservation& seen : map.keyframes[k].observations) {
      const Eigen::Vector3d x = map.keyframes[k].camera_from_world * map.landmarks[seen.landmark].position;
      sum += (map.camera.pinhole.Project(x) - seen.pixel).squaredNorm();
      ++count;
    }
  return std::sqrt(sum / count);
}

TEST(RollingShutter, PixelsAreThoseOfAGlobalShutter) {
  for (const double readout : {kReadout, -kReadout}) {
    Map map = TurningMap(readout);
    const int last = CountKeyframes(map) - 1;
    const double before = RmsError(map, 1, last - 1);
    CorrectRows(map);
    EXPECT_LT(RmsError(map, 1, last - 1), 0.2 * before) << "to second order";
    for (int i = 0; i < static_cast<int>(map.landmarks.size()); ++i)
      for (const LandmarkObservation& seen : map.landmarks[i].observations) {
        const auto& of_keyframe = map.keyframes[seen.keyframe].observations;
        const auto same = std::ranges::find(of_keyframe, i, &KeyframeObservation::landmark);
        ASSERT_NE(same, of_keyframe.end());
        EXPECT_EQ(same->pixel, seen.pixel);
      }
  }
}

TEST(RollingShutter, MotionIsNotTakenAcrossAGap) {
  Map map = TurningMap(kReadout);
  const int gap = CountKeyframes(map) / 2;
  const double before = RmsError(map, gap - 1, gap);
  // Before the gap, the car was elsewhere.
  map.keyframes[gap].after_gap = true;
  map.keyframes[gap - 1].observations.clear();
  map.keyframes[gap - 1].camera_from_world.translation += Eigen::Vector3d(100, 0, 1000);
  for (Landmark& landmark : map.landmarks)
    std::erase_if(landmark.observations, [&](const LandmarkObservation& seen) { return seen.keyframe == gap - 1; });
  CorrectRows(map);
  EXPECT_LT(RmsError(map, gap, gap), 0.2 * before);
}

TEST(RollingShutter, NothingMovesWithoutTheSizeOfTheImage) {
  Map map = TurningMap(kReadout);
  const int last = CountKeyframes(map) - 1;
  const double before = RmsError(map, 0, last);
  map.camera.height = 0;
  CorrectRows(map);
  EXPECT_EQ(RmsError(map, 0, last), before);
}

TEST(RollingShutter, MiddleRowDoesNotWait) {
  const Map map = TurningMap(0);
  const Eigen::Vector3d position = map.keyframes[20].camera_from_world.inverse() * Eigen::Vector3d(1, 0, 9);
  EXPECT_EQ(RowMotion(map, 20, position, {600, 0.5 * (map.camera.height - 1)}, {}).norm(), 0);
  EXPECT_GT(RowMotion(map, 20, position, {600, map.camera.height - 1}, {}).norm(), 1);
  EXPECT_EQ(
      RowMotion(map, 20, map.keyframes[20].camera_from_world.inverse() * Eigen::Vector3d(1, 0, -9), {600, 300}, {})
          .norm(),
      0)
      << "behind the camera";
}

}  // namespace
}  // namespace turnscale
