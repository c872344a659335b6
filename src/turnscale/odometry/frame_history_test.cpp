// SPDX-License-Identifier: MIT
#include "turnscale/odometry/frame_history.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Keyframes 1 and 3 units ahead; their places in metres, at 2 and 5 metres a unit.
Map KeyframesAhead() {
  Map map;
  const Eigen::Quaterniond turned = RotationFromVector({0.1, 0.4, -0.2});
  map.keyframes.push_back({0, 0, RigidTransform{turned, {0, 0, 1}}.inverse(), {}, false});
  map.keyframes.push_back({5, 0.5, RigidTransform{turned, {0, 0, 3}}.inverse(), {}, false});
  return map;
}

const MetricPath kPath{{{0, 0, 2}, {0, 0, 9}}, {2, 5}};

TEST(MetricPath, AKeyframeIsWhereThePathHasIt) {
  const Map map = KeyframesAhead();
  for (const int k : {0, 1}) {
    const RigidTransform pose = map.keyframes[k].camera_from_world.inverse();
    const RigidTransform metric = kPath.InMetres(map, k, pose);
    EXPECT_LT((metric.translation - kPath.centres[k]).norm(), 1e-12);
    EXPECT_LT(metric.rotation.angularDistance(pose.rotation), 1e-12);
  }
}

TEST(MetricPath, WhatIsNearAKeyframeIsAsFarInItsMetres) {
  const Map map = KeyframesAhead();
  const Eigen::Vector3d off(0.3, -0.1, 0.2);
  EXPECT_LT((kPath.InMetres(map, 0, Eigen::Vector3d(0, 0, 1) + off) - (kPath.centres[0] + 2 * off)).norm(), 1e-12);
  EXPECT_LT((kPath.InMetres(map, 1, Eigen::Vector3d(0, 0, 3) + off) - (kPath.centres[1] + 5 * off)).norm(), 1e-12);
}

FrameResult Frame(int frame, TrackingState state) {
  FrameResult result;
  result.frame = frame;
  result.time = 0.1 * frame;
  result.state = state;
  return result;
}

RigidTransform At(double x, double yaw = 0) {
  const RigidTransform world_from_camera{RotationFromVector({0, yaw, 0}), {x, 0, 0}};
  return world_from_camera.inverse();
}

Map TwoKeyframes() {
  Map map;
  map.keyframes.push_back({0, 0, At(0), {}, false});
  map.keyframes.push_back({5, 0.5, At(10), {}, false});
  return map;
}

/// The map itself, in its own unit.
MetricPath OwnUnit(const Map& map) {
  MetricPath path;
  for (const Keyframe& keyframe : map.keyframes) {
    path.centres.push_back(Centre(keyframe));
    path.metres_per_unit.push_back(1);
  }
  return path;
}

double X(const FrameResult& frame) { return frame.world_from_camera.value().translation.x(); }

TEST(FrameHistory, FramesGoWithTheirKeyframe) {
  Map map = TwoKeyframes();
  FrameHistory history;
  history.Add(Frame(0, TrackingState::kTracked), map, 0, At(0));
  history.Add(Frame(1, TrackingState::kTracked), map, 0, At(2));
  history.Add(Frame(2, TrackingState::kTracked), map, 1, At(11));
  EXPECT_EQ(history.Keyframes(), (std::vector<int>{0, 0, 1}));
  std::vector<FrameResult> frames = history.Refined(map, OwnUnit(map));
  EXPECT_NEAR(X(frames[1]), 2, 1e-12);
  EXPECT_NEAR(X(frames[2]), 11, 1e-12);
  map.keyframes[1].camera_from_world = At(20, M_PI / 2);
  frames = history.Refined(map, OwnUnit(map));
  EXPECT_NEAR(X(frames[1]), 2, 1e-12);
  EXPECT_NEAR(X(frames[2]), 20, 1e-12) << "a metre to the right of a keyframe that has turned right is behind it";
  EXPECT_NEAR(frames[2].world_from_camera->translation.z(), -1, 1e-12);
}

TEST(FrameHistory, TheLastMeasuredFrameOfAKeyframeEndsItsPart) {
  const Map map = TwoKeyframes();
  FrameHistory history;
  history.Add(Frame(0, TrackingState::kTracked), map, 0, At(0));
  history.Add(Frame(1, TrackingState::kTracked), map, 0, At(2));
  history.Add(Frame(2, TrackingState::kBridged), map, 0, At(4));
  const std::vector<MeasuredEnd> ends = history.MeasuredEnds(map);
  ASSERT_EQ(ends.size(), 2U);
  EXPECT_NEAR(ends[0].time, 0.1, 1e-12);
  EXPECT_NEAR(ends[0].centre.x(), 2, 1e-12);
  EXPECT_EQ(ends[1].time, 0.5) << "no frame but the keyframe";
  EXPECT_NEAR(ends[1].centre.x(), 10, 1e-12);
}

TEST(FrameHistory, LengthsAreRescaledKeyframeByKeyframe) {
  const Map map = TwoKeyframes();
  FrameHistory history;
  history.AddWithoutPose(Frame(0, TrackingState::kInitializing));
  history.Add(Frame(1, TrackingState::kTracked), map, 0, At(2));
  history.Add(Frame(2, TrackingState::kTracked), map, 1, At(11));
  history.Rescale(0, {3, 5});
  const std::vector<FrameResult> frames = history.Refined(map, OwnUnit(map));
  EXPECT_NEAR(X(frames[1]), 6, 1e-12);
  EXPECT_NEAR(X(frames[2]), 15, 1e-12);
}

TEST(FrameHistory, FramesAreInTheMetresOfTheirKeyframe) {
  const Map map = TwoKeyframes();
  FrameHistory history;
  history.Add(Frame(0, TrackingState::kTracked), map, 0, At(0));
  history.Add(Frame(1, TrackingState::kTracked), map, 0, At(2));
  history.Add(Frame(2, TrackingState::kBridged), map, 0, At(7));
  history.Add(Frame(3, TrackingState::kTracked), map, 1, At(11, 0.3));
  // 60 m/s before the gap and in it.
  const MetricPath path{{{100, 0, 0}, {110, 0, 0}}, {3, 8}};
  const std::vector<FrameResult> frames = history.Refined(map, path);
  EXPECT_NEAR(X(frames[0]), 100, 1e-12);
  EXPECT_NEAR(X(frames[1]), 106, 1e-12);
  EXPECT_NEAR(X(frames[3]), 118, 1e-12);
  EXPECT_NEAR(X(frames[2]), 112, 1e-12) << "bridged in metres";
  EXPECT_NEAR(TwistAboutY(frames[3].world_from_camera->rotation), 0.3, 1e-12);
}

TEST(FrameHistory, AFrameMayGetItsPoseLater) {
  const Map map = TwoKeyframes();
  FrameHistory history;
  history.AddWithoutPose(Frame(0, TrackingState::kInitializing));
  history.AddWithoutPose(Frame(1, TrackingState::kInitializing));
  for (const FrameResult& frame : history.Refined(map, OwnUnit(map))) EXPECT_FALSE(frame.world_from_camera);
  EXPECT_EQ(history.Keyframes(), (std::vector<int>{-1, -1}));
  history.Add(Frame(0, TrackingState::kTracked), map, 0, At(4));
  const std::vector<FrameResult> frames = history.Refined(map, OwnUnit(map));
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].state, TrackingState::kTracked);
  EXPECT_NEAR(X(frames[0]), 4, 1e-12);
  EXPECT_FALSE(frames[1].world_from_camera);
}

TEST(FrameHistory, BridgedFramesGoEvenlyBetweenMeasuredOnes) {
  const Map map = TwoKeyframes();
  FrameHistory history;
  history.Add(Frame(0, TrackingState::kTracked), map, 0, At(1, 0));
  history.Add(Frame(1, TrackingState::kBridged), map, 0, At(50));
  history.Add(Frame(2, TrackingState::kUnreadable), map, 0, At(60));
  FrameResult late = Frame(3, TrackingState::kBridged);
  late.time = 0.35;
  history.Add(late, map, 0, At(70));
  history.Add(Frame(4, TrackingState::kTracked), map, 1, At(9, 0.4));
  history.Add(Frame(5, TrackingState::kBridged), map, 1, At(11));
  const std::vector<FrameResult> frames = history.Refined(map, OwnUnit(map));
  EXPECT_NEAR(X(frames[1]), 3, 1e-12);
  EXPECT_NEAR(X(frames[2]), 5, 1e-12);
  EXPECT_NEAR(X(frames[3]), 8, 1e-12) << "even in time, not in number";
  EXPECT_NEAR(TwistAboutY(frames[2].world_from_camera->rotation), 0.2, 1e-12);
  EXPECT_NEAR(X(frames[5]), 11, 1e-12) << "nothing measured comes after it";
  EXPECT_EQ(frames[2].state, TrackingState::kUnreadable);
}

// A car on a circle: halfway through a gap of 0.6 s, a straight line would be 0.3 m inside of it.
TEST(FrameHistory, AGapInATurnIsBent) {
  constexpr double kRadius = 7;
  constexpr double kTurning = 1.0;  // rad/s
  const auto on_circle = [&](double time) {
    const double turned = kTurning * time;
    return RigidTransform{RotationFromVector({0, turned, 0}),
                          kRadius * Eigen::Vector3d(1 - std::cos(turned), 0, std::sin(turned))};
  };
  Map map;
  map.keyframes.push_back({0, 0, on_circle(0).inverse(), {}, false});
  FrameHistory history;
  for (int i = 0; i < 11; ++i) {
    const TrackingState state = i > 2 && i < 8 ? TrackingState::kRepeated : TrackingState::kTracked;
    history.Add(Frame(i, state), map, 0, on_circle(0.1 * i).inverse());
  }
  const std::vector<FrameResult> frames = history.Refined(map, OwnUnit(map));
  for (int i = 3; i < 8; ++i) {
    const RigidTransform truth = on_circle(0.1 * i);
    EXPECT_LT((frames[i].world_from_camera->translation - truth.translation).norm(), 0.05) << i;
    EXPECT_LT(frames[i].world_from_camera->rotation.angularDistance(truth.rotation), 1e-9) << i;
  }
}

TEST(FrameHistory, ACarThatStandsAfterAGapHasNotGoneFarther) {
  const Map map = TwoKeyframes();
  FrameHistory history;
  const std::vector<double> places = {0, 3, 0, 0, 0, 0, 3.5, 3.5};
  for (int i = 0; i < static_cast<int>(places.size()); ++i)
    history.Add(Frame(i, i > 1 && i < 6 ? TrackingState::kBridged : TrackingState::kTracked), map, 0, At(places[i]));
  const std::vector<FrameResult> frames = history.Refined(map, OwnUnit(map));
  for (int i = 2; i < 6; ++i) {
    EXPECT_GE(X(frames[i]), X(frames[i - 1])) << i;
    EXPECT_LE(X(frames[i]), 3.5) << i;
  }
}

TEST(FrameHistory, FramesThatWereNotMeasuredAfterAllAreInterpolated) {
  const Map map = TwoKeyframes();
  FrameHistory history;
  history.Add(Frame(0, TrackingState::kTracked), map, 0, At(0));
  history.Add(Frame(1, TrackingState::kTracked), map, 0, At(2));
  for (const int frame : {2, 3}) history.Add(Frame(frame, TrackingState::kRepeated), map, 0, At(2));
  history.Add(Frame(4, TrackingState::kTracked), map, 0, At(2));
  history.ForgetMeasured(Frame(1, TrackingState::kTracked).time);
  history.Add(Frame(5, TrackingState::kTracked), map, 1, At(11));
  const std::vector<FrameResult> frames = history.Refined(map, OwnUnit(map));
  for (const int i : {2, 3, 4}) {
    EXPECT_EQ(frames[i].state, TrackingState::kBridged);
    EXPECT_GT(X(frames[i]), X(frames[i - 1]) + 0.5);
  }
  EXPECT_EQ(frames[1].state, TrackingState::kTracked);
}

TEST(FrameHistory, FramesBeforeTheFirstPoseHaveThatPose) {
  const Map map = TwoKeyframes();
  FrameHistory history;
  for (const int frame : {0, 1, 2}) history.AddWithoutPose(Frame(frame, TrackingState::kInitializing));
  history.Add(Frame(3, TrackingState::kTracked), map, 0, At(2, 0.3));
  history.Add(Frame(4, TrackingState::kTracked), map, 0, At(4, 0.3));
  const std::vector<FrameResult> frames = history.Refined(map, OwnUnit(map));
  for (const int i : {0, 1, 2}) {
    EXPECT_NEAR(X(frames[i]), 2, 1e-12);
    EXPECT_NEAR(TwistAboutY(frames[i].world_from_camera->rotation), 0.3, 1e-12);
    EXPECT_EQ(frames[i].state, TrackingState::kInitializing);
  }
}

}  // namespace
}  // namespace turnscale
