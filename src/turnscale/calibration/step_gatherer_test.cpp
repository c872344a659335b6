// SPDX-License-Identifier: MIT
#include "turnscale/calibration/step_gatherer.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

TEST(StepsAlong, MeansOverTheWantedTime) {
  const auto steps = StepsAlong(TestPath({{61, 0.8, 0.05}}, {1.2, 0}, Eigen::Quaterniond::Identity()));
  ASSERT_EQ(steps.size(), 10U);
  const RigidTransform truth = SlippingCameraMotion({1, 0.8, 0.05}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  for (const CameraStep& step : steps) {
    EXPECT_EQ(step.frames, 6);
    EXPECT_NEAR(step.end - step.begin, 0.6, 1e-9);
    EXPECT_LT((step.previous_from_current.translation - truth.translation).norm(), 1e-12);
    EXPECT_LT(step.previous_from_current.rotation.angularDistance(truth.rotation), 1e-12);
  }
}

TEST(StepsAlong, TheUnitOfLengthDoesNotMatter) {
  Trajectory path = TestPath(TestRoute({1, -1}), {1, 0}, Eigen::Quaterniond::Identity(), 0.2 * kDeg);
  const auto metres = StepsAlong(path);
  for (StampedPose& pose : path) pose.world_from_camera.translation *= 0.031;
  const auto units = StepsAlong(path);
  ASSERT_EQ(metres.size(), units.size());
  for (size_t i = 0; i < units.size(); ++i) EXPECT_EQ(units[i].frames, metres[i].frames);
}

TEST(StepsAlong, StandingGivesNoSteps) {
  Trajectory path = TestPath(TestRoute({}), {1, 0}, Eigen::Quaterniond::Identity());
  const size_t moving = StepsAlong(path).size();
  const StampedPose last = path.back();
  for (int i = 1; i <= 100; ++i) path.push_back({last.time + 0.1 * i, last.world_from_camera});
  // A time of standing longer than the drive changes what is usual, up to the quantile.
  path.resize(path.size() - 85);
  EXPECT_EQ(StepsAlong(path).size(), moving);
}

TEST(StepsAlong, RefusesPosesThatAreNone) {
  Trajectory path = TestPath(TestRoute({}), {1, 0}, Eigen::Quaterniond::Identity());
  path[5].time = path[4].time;
  EXPECT_THROW(StepsAlong(path), InputError);
  path[5].time = path[4].time + 0.01;
  path[9].world_from_camera.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(StepsAlong(path), InputError);
}

TEST(StepGatherer, GivesTheSameStepsFrameByFrame) {
  const Trajectory path = TestPath(TestRoute({1, -1}), {1, 0}, Eigen::Quaterniond::Identity());
  const auto all = StepsAlong(path);
  StepGatherer gatherer;
  size_t found = 0;
  for (const StampedPose& pose : path) {
    const auto step = gatherer.Add(pose);
    if (!step) continue;
    ASSERT_LT(found, all.size());
    EXPECT_EQ(step->end, all[found].end);
    ++found;
  }
  EXPECT_EQ(found, all.size());
}

TEST(StepGatherer, NoStepReachesAcrossABreak) {
  const Trajectory path = TestPath({{40, 0.8, 0}}, {1, 0}, Eigen::Quaterniond::Identity());
  StepGatherer gatherer;
  for (size_t i = 0; i < path.size(); ++i) {
    if (i == 20) gatherer.Break();
    const auto step = gatherer.Add(path[i]);
    EXPECT_TRUE(!step || step->end < path[20].time || step->begin >= path[20].time);
  }
}

TEST(StepOptions, RefuseSenselessValues) {
  EXPECT_EQ(RefusedField<StepOptions>([](StepOptions& o) { o.duration = 0; }), "duration");
  EXPECT_EQ(RefusedField<StepOptions>([](StepOptions& o) { o.max_slowness = 0.5; }), "max_slowness");
  EXPECT_EQ(RefusedField<StepOptions>([](StepOptions& o) { o.usual_speed_quantile = 1; }), "usual_speed_quantile");
  EXPECT_EQ(RefusedField<StepOptions>([](StepOptions& o) { o.speed_memory = 0; }), "speed_memory");
}

}  // namespace
}  // namespace turnscale
