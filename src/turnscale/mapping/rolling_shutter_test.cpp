// SPDX-License-Identifier: MIT
#include "turnscale/mapping/rolling_shutter.h"

#include <algorithm>

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

// Of the pixels of keyframes `first`...`last` from where the landmarks project.
double LargestError(const Map& map, int first, int last) {
  double largest = 0;
  for (int k = first; k <= last; ++k)
    for (const KeyframeObservation& seen : map.keyframes[k].observations) {
      const Eigen::Vector3d x = map.keyframes[k].camera_from_world * map.landmarks[seen.landmark].position;
      largest = std::max(largest, (map.camera.pinhole.Project(x) - seen.pixel).norm());
    }
  return largest;
}

TEST(RollingShutter, PixelsAreThoseOfAGlobalShutter) {
  for (const double readout : {kReadout, -kReadout}) {
    Map map = TurningMap(readout);
    const int last = CountKeyframes(map) - 1;
    ASSERT_GT(LargestError(map, 1, last - 1), 5);
    CorrectRows(map);
    EXPECT_LT(LargestError(map, 1, last - 1), 0.6) << "at the edge of the image; to second order";
    for (const Landmark& landmark : map.landmarks)
      for (const LandmarkObservation& seen : landmark.observations) {
        const auto& of_keyframe = map.keyframes[seen.keyframe].observations;
        EXPECT_TRUE(std::ranges::any_of(
            of_keyframe, [&](const KeyframeObservation& other) { return other.pixel == seen.pixel; }));
      }
  }
}

TEST(RollingShutter, MotionIsNotTakenAcrossAGap) {
  Map map = TurningMap(kReadout);
  // What follows is another place.
  map.keyframes[20].after_gap = true;
  for (int k = 20; k < CountKeyframes(map); ++k) map.keyframes[k].camera_from_world.translation.x() += 1000;
  for (Landmark& landmark : map.landmarks) {
    std::erase_if(landmark.observations, [](const LandmarkObservation& seen) { return seen.keyframe >= 20; });
    landmark.valid = !landmark.observations.empty();
  }
  for (int k = 20; k < CountKeyframes(map); ++k) map.keyframes[k].observations.clear();
  CorrectRows(map);
  EXPECT_LT(LargestError(map, 1, 19), 1.5);
}

TEST(RollingShutter, NothingMovesWithoutTheSizeOfTheImage) {
  Map map = TurningMap(kReadout);
  const int last = CountKeyframes(map) - 1;
  const double before = LargestError(map, 0, last);
  map.camera.height = 0;
  CorrectRows(map);
  EXPECT_EQ(LargestError(map, 0, last), before);
}

TEST(RollingShutter, MiddleRowDoesNotWait) {
  const Map map = TurningMap(0);
  const Eigen::Vector3d position = map.keyframes[20].camera_from_world.inverse() * Eigen::Vector3d(1, 0, 9);
  EXPECT_EQ(RowMotion(map, 20, position, 0.5 * (map.camera.height - 1)).norm(), 0);
  EXPECT_GT(RowMotion(map, 20, position, map.camera.height - 1).norm(), 1);
  EXPECT_EQ(RowMotion(map, 20, map.keyframes[20].camera_from_world.inverse() * Eigen::Vector3d(1, 0, -9), 300).norm(),
            0) << "behind the camera";
}

}  // namespace
}  // namespace turnscale
