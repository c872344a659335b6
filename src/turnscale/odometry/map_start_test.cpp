// SPDX-License-Identifier: MIT
#include "turnscale/odometry/map_start.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

const CameraModel kCamera{.pinhole = {400, 400, 320, 240}, .width = 640, .height = 480};

/// A camera that goes straight ahead by `speed` a second, ten frames a second, sees a wall of points. The first and the
/// last of four frames give the map.
struct Start {
  InitialMap map;
  std::vector<RigidTransform> poses;  ///< of the frames, from the first view
};

Start GoingAhead(double first_time, double speed, double depth) {
  Start start;
  constexpr int kFrames = 4;
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 10; ++column)
      start.map.points.emplace_back(0.12 * depth * (column - 4.5), 0.12 * depth * (row - 3.5), depth + 0.1 * (row % 3));
  start.map.has_point.assign(start.map.points.size(), 1);
  start.map.first_image = cv::Mat::zeros(480, 640, CV_8UC1);
  for (int i = 0; i < kFrames; ++i) {
    const RigidTransform pose{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, -0.1 * speed * i)};
    WaitingFrame frame{.frame = 20 + i, .time = first_time + 0.1 * i, .features = {}, .undistorted = {}};
    for (std::size_t k = 0; k < start.map.points.size(); ++k) {
      frame.features.push_back(static_cast<int>(k));
      frame.undistorted.push_back(kCamera.pinhole.Project(pose * start.map.points[k]));
      if (i == 0) start.map.first_pixels.emplace_back(frame.undistorted.back().x(), frame.undistorted.back().y());
      if (i == kFrames - 1)
        start.map.second_pixels.emplace_back(frame.undistorted.back().x(), frame.undistorted.back().y());
    }
    start.map.frames.push_back(frame);
    start.poses.push_back(pose);
  }
  start.map.second_from_first = start.poses.back();
  return start;
}

Map EmptyMap() {
  Map map;
  map.camera = kCamera;
  return map;
}

TEST(MapStart, HasPixelsOfTheMapsCamera) {
  Map map = EmptyMap();
  map.camera.radial_correction = 0.01;
  EXPECT_THROW(AddStart(GoingAhead(5, 2, 10).map, {}, map), InternalError);
  EXPECT_TRUE(map.keyframes.empty());
}

TEST(MapStart, IsAddedWithItsUnit) {
  const Start start = GoingAhead(5, 2, 10);
  Map map = EmptyMap();
  AddStart(start.map, {}, map);
  EXPECT_FALSE(map.keyframes[0].after_gap);
  EXPECT_EQ(map.keyframes[0].gap_sigma, 0);
  const RigidTransform place{RotationFromVector({0, 0.3, 0}), {1, 0, 2}};
  const AddedStart added = AddStart(start.map, {{place, 0.1}, {3, 0.2}, true}, map);
  EXPECT_EQ(added.keyframe, 2);
  EXPECT_EQ(added.first_landmark, static_cast<int>(start.map.points.size()));
  ASSERT_EQ(map.keyframes.size(), 4U);
  EXPECT_TRUE(map.keyframes[2].after_gap);
  EXPECT_EQ(map.keyframes[2].gap_sigma, 0.2);
  EXPECT_EQ(map.keyframes[2].gap_turn_sigma, 0.1);
  EXPECT_FALSE(map.keyframes[3].after_gap);
  EXPECT_NEAR((Centre(map.keyframes[3]) - Centre(map.keyframes[2])).norm(), 3 * 0.6, 1e-12);
  ASSERT_EQ(added.tracks.size(), start.map.points.size());
  for (const FeatureTrack& track : added.tracks) {
    const Eigen::Vector3d& position = map.landmarks[track.landmark].position;
    EXPECT_LT((map.camera.pinhole.Project(map.keyframes[3].camera_from_world * position) - track.undistorted).norm(),
              1e-9);
    EXPECT_EQ(map.landmarks[track.landmark].observations.size(), 2U);
    EXPECT_EQ(track.last_keyframe, 3);
  }
}

TEST(MapStart, FramesInBetweenAreLocated) {
  Start start = GoingAhead(5, 2, 10);
  // The third image is the second one once more.
  start.map.frames[2].undistorted = start.map.frames[1].undistorted;
  Map map = EmptyMap();
  const AddedStart added = AddStart(start.map, {}, map);
  MotionModel motion;
  const std::vector<LocatedFrame> located = LocateWaitingFrames({}, start.map, added, map, motion);
  ASSERT_EQ(located.size(), 3U) << "the second view is a keyframe";
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(located[i].result.frame, 20 + i);
    EXPECT_EQ(located[i].result.state, TrackingState::kTracked);
    EXPECT_EQ(located[i].result.keyframe, i == 0);
    EXPECT_LT((located[i].camera_from_world.translation - start.poses[i].translation).norm(), 1e-6);
  }
  EXPECT_EQ(located[2].result.state, TrackingState::kRepeated);
  EXPECT_LT((located[2].camera_from_world.translation - start.poses[2].translation).norm(), 1e-3) << "predicted";
  EXPECT_EQ(motion.last_measured_time(), start.map.frames.back().time);
}

TEST(MapStart, APoseThatNoOneBelievesIsNoMotion) {
  Start start = GoingAhead(5, 2, 10);
  for (std::size_t i = 0; i < start.map.frames[2].undistorted.size(); ++i)
    start.map.frames[2].undistorted[i] += Eigen::Vector2d(i % 2 == 0 ? 40 : -40, i % 3 == 0 ? 30 : -30);
  Map map = EmptyMap();
  const AddedStart added = AddStart(start.map, {}, map);
  MotionModel motion;
  const std::vector<LocatedFrame> located = LocateWaitingFrames({}, start.map, added, map, motion);
  ASSERT_EQ(located.size(), 3U);
  EXPECT_EQ(located[2].result.state, TrackingState::kBridged);
  const double after = start.map.frames[3].time + 0.1;
  const RigidTransform moved = motion.Predict(after) * motion.last().inverse();
  const RigidTransform step = start.poses[1] * start.poses[0].inverse();
  EXPECT_LT((moved.translation - step.translation).norm(), 0.01 * step.translation.norm());
}

TEST(MapStart, TheUnitAfterAGapFollowsFromDepthAndSpeed) {
  // The same speed in a unit that is twice as long; the second views are 19.4 and 9.7 before the wall.
  const Start before = GoingAhead(5, 2, 20);
  Map map = EmptyMap();
  const AddedStart added = AddStart(before.map, {}, map);
  MotionModel motion;
  LocateWaitingFrames({}, before.map, added, map, motion);
  const TrackingOptions options;
  const UnitGuess both = UnitAfterGap(options, map, motion, GoingAhead(6, 1, 10).map);
  EXPECT_NEAR(both.unit, 2, 0.01);
  EXPECT_LT(both.sigma, options.depth_sigma);
  // Three times as fast after the gap: speed and depth contradict each other.
  const UnitGuess faster = UnitAfterGap(options, map, motion, GoingAhead(6, 3, 10.6).map);
  EXPECT_LT(faster.unit, 1.9);
  EXPECT_GT(faster.unit, 2.0 / 3);
  EXPECT_GT(faster.sigma, both.sigma);
}

// As behind a lorry that hides most of the scene from a car that waits.
TEST(MapStart, NoiseOfStandingIsNoSpeedWhereFewDepthsAreKnown) {
  const Start before = GoingAhead(5, 2, 20);
  Map map = EmptyMap();
  AddStart(before.map, {}, map);
  for (std::size_t i = 0; i < map.landmarks.size(); ++i)
    if (i % 5 != 0) map.landmarks[i].valid = false;
  const auto standing = [&](double noise) {
    MotionModel motion;
    motion.Update(5, RigidTransform{});
    motion.Update(5.1, {Eigen::Quaterniond::Identity(), {0, 0, -noise}});
    return UnitAfterGap({}, map, motion, GoingAhead(6, 1, 10).map);
  };
  EXPECT_GE(standing(0.005).sigma, 1) << "nothing is known";
  EXPECT_LT(standing(1.0).sigma, 0.5);
  for (Landmark& landmark : map.landmarks) landmark.valid = false;
  EXPECT_GE(standing(1.0).sigma, 1) << "no depth at all";
}

TEST(MapStart, ACarStandsAtFirstOrDrives) {
  const auto begins_at_standstill = [](const Start& start) { return BeginsAtStandstill({}, start.map); };
  Start start = GoingAhead(5, 2, 10);
  EXPECT_FALSE(begins_at_standstill(start));
  Start waiting = start;
  for (std::size_t i = 1; i + 1 < waiting.map.frames.size(); ++i)
    waiting.map.frames[i].undistorted = waiting.map.frames[0].undistorted;
  EXPECT_TRUE(begins_at_standstill(waiting));
  for (WaitingFrame& frame : waiting.map.frames) frame.time = 5 + 0.1 * (frame.time - 5);
  EXPECT_FALSE(begins_at_standstill(waiting)) << "for too short a time to tell";
  // Most of the image is a dashboard.
  for (std::size_t i = 1; i < start.map.frames.size(); ++i)
    std::copy_n(start.map.frames[0].undistorted.begin(), 64, start.map.frames[i].undistorted.begin());
  EXPECT_FALSE(begins_at_standstill(start));
}

TEST(MapStart, AfterAGapTheCarHasTurnedAsImagesOrRatesShow) {
  Start start = GoingAhead(7, 2, 10);
  MotionModel motion;
  motion.Update(5, RigidTransform{});
  motion.Update(5.1, {Eigen::Quaterniond::Identity(), {0, 0, -0.2}});
  const auto turn_of = [](const RigidTransform& pose) { return VectorFromRotation(pose.rotation).y(); };
  EXPECT_NEAR(turn_of(PredictStart(motion, start.map, std::nullopt, {}).first_from_world), 0, 1e-9);

  start.map.second_from_first.rotation = RotationFromVector({0, -0.15, 0});  // in 0.3 s
  const RigidTransform by_rates = PredictStart(motion, start.map, std::nullopt, {}).first_from_world;
  EXPECT_LT(turn_of(by_rates), -0.3);
  EXPECT_GT(turn_of(by_rates), -0.5);

  const Eigen::Quaterniond measured = RotationFromVector({0.02, -0.6, 0});
  const PredictedStart measured_start = PredictStart(motion, start.map, GapRotation{measured, 0.01}, {});
  EXPECT_TRUE(measured_start.turn_is_measured);
  EXPECT_EQ(measured_start.turn_sigma, 0.01);
  const RigidTransform& by_images = measured_start.first_from_world;
  EXPECT_LT(RotationAngle(by_images.rotation.conjugate() * measured), 1e-9);
  const Eigen::Vector3d centre = by_images.inverse().translation;
  EXPECT_NEAR(std::atan2(centre.x(), centre.z()), 0.2, 0.1) << "the car turns mostly after the middle of the gap";
  const PredictedStart by_rates_start = PredictStart(motion, start.map, std::nullopt, {});
  EXPECT_FALSE(by_rates_start.turn_is_measured);
  EXPECT_GT(by_rates_start.turn_sigma, 0.1);

  motion.Stop();
  EXPECT_LT(PredictStart(motion, start.map, std::nullopt, {}).first_from_world.inverse().translation.z(), 0.21)
      << "a car that stood is where it was";
}

}  // namespace
}  // namespace turnscale
