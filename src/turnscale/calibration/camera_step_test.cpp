// SPDX-License-Identifier: MIT
#include "turnscale/calibration/camera_step.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/calibration/test_drive.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {
namespace {

void Drive(UsualSpeed& speed, double metres_per_second, double seconds) {
  for (int i = 0; i < 10 * seconds; ++i) speed.Add(0.1 * metres_per_second, 0.1);
}

TEST(UsualSpeed, IsTheSpeedThatHalfOfTheWayIsDrivenAt) {
  UsualSpeed speed;
  EXPECT_EQ(speed.value(), 0);
  Drive(speed, 5, 30);
  EXPECT_NEAR(speed.value(), 5, 1e-9);
  Drive(speed, 20, 6);
  EXPECT_NEAR(speed.value(), 5, 1e-9);
  Drive(speed, 20, 3);
  EXPECT_NEAR(speed.value(), 20, 1e-9);
}

TEST(UsualSpeed, StandingDoesNotCount) {
  UsualSpeed speed(60);
  Drive(speed, 8, 60);
  Drive(speed, 0.1, 600);
  Drive(speed, 0, 600);
  EXPECT_NEAR(speed.value(), 8, 1e-9);
}

TEST(UsualSpeed, ForgetsWhatWasLongAgo) {
  UsualSpeed all;
  UsualSpeed latest(60);
  for (UsualSpeed* speed : {&all, &latest}) {
    Drive(*speed, 30, 600);
    Drive(*speed, 5, 900);
  }
  EXPECT_NEAR(all.value(), 30, 1e-9);
  EXPECT_NEAR(latest.value(), 5, 1e-9);
}

TEST(UsualSpeed, AnyUnitWillDo) {
  UsualSpeed metres;
  UsualSpeed units;
  for (const double speed : {3.0, 7.3, 7.5, 7.7, 9.0, 2.0}) {
    metres.Add(speed, 1);
    units.Add(0.0371 * speed, 1);
  }
  EXPECT_NEAR(units.value() / metres.value(), 0.0371, 1e-12);
}

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

// A camera that stands for so many seconds, where the path is, and trembles.
void Stand(Trajectory& path, double seconds, double rate_hz, double tremble) {
  Random random(9);
  const StampedPose place = path.back();
  for (int i = 1; i <= seconds * rate_hz; ++i) {
    StampedPose pose = place;
    pose.time += i / rate_hz;
    for (double& x : pose.world_from_camera.translation) x += tremble * random.Gaussian();
    path.push_back(pose);
  }
}

void Append(Trajectory& path, const Trajectory& more) {
  const StampedPose end = path.back();
  for (size_t i = 1; i < more.size(); ++i) {
    path.push_back({end.time + more[i].time, end.world_from_camera * more[i].world_from_camera});
  }
}

// Most of the time at a light, at 30 frames a second; the route begins before, between or after.
TEST(StepGatherer, ALongNoisyStopGivesNoSteps) {
  const Trajectory drive = TestPath(TestRoute({1}), {1, 0}, Eigen::Quaterniond::Identity());
  const size_t steps = StepsAlong(drive).size();
  Trajectory begins_standing{StampedPose{}};
  Stand(begins_standing, 60, 30, 0.003);
  Append(begins_standing, drive);
  Trajectory stops = drive;
  Stand(stops, 60, 30, 0.003);
  Append(stops, drive);
  const auto count = [](const Trajectory& path) {
    StepGatherer gatherer;
    size_t found = 0;
    for (const StampedPose& pose : path) found += gatherer.Add(pose).has_value() ? 1 : 0;
    return found;
  };
  EXPECT_NEAR(static_cast<double>(StepsAlong(begins_standing).size()), static_cast<double>(steps), 1);
  EXPECT_NEAR(static_cast<double>(StepsAlong(stops).size()), 2 * static_cast<double>(steps), 2);
  EXPECT_NEAR(static_cast<double>(count(begins_standing)), static_cast<double>(steps), 3);
  EXPECT_NEAR(static_cast<double>(count(stops)), 2 * static_cast<double>(steps), 4);
}

TEST(StepsAlong, AStretchOfStandingIsNoDrive) {
  const Trajectory drive = TestPath(TestRoute({}), {1, 0}, Eigen::Quaterniond::Identity());
  Trajectory standing{StampedPose{}};
  Stand(standing, 30, 10, 0.003);
  EXPECT_EQ(StepsAlong(std::vector<Trajectory>{drive, standing}).size(), StepsAlong(drive).size());
}

TEST(StepsAlong, NoStepReachesAcrossAGapOrAJump) {
  const Trajectory path = TestPath(TestRoute({1}), {1, 0}, Eigen::Quaterniond::Identity());
  Trajectory gap;
  for (const StampedPose& pose : path) {
    if (pose.time < 5.95 || pose.time > 9.95) gap.push_back(pose);
  }
  Trajectory jump = path;
  for (StampedPose& pose : jump) pose.world_from_camera.translation.x() += pose.time > 6.95 ? 30 : 0;
  EXPECT_GT(StepsAlong(gap).size(), 15U);
  EXPECT_GT(StepsAlong(jump).size(), 15U);
  EXPECT_EQ(FirstGap(path), std::nullopt);
  EXPECT_NEAR(FirstGap(gap).value_or(0), 5.9, 1e-9);
  EXPECT_NEAR(FirstGap(jump).value_or(0), 6.9, 1e-9);
  for (const CameraStep& step : StepsAlong(gap)) EXPECT_TRUE(step.end < 5.95 || step.begin > 9.95);
  for (const CameraStep& step : StepsAlong(jump)) EXPECT_TRUE(step.end < 6.95 || step.begin > 6.95);
}

// Keyframes at unequal spacing on a bend: the camera swings out by its lever arm all the same.
TEST(StepsAlong, UnequalFramesObeyTheKinematics) {
  const Trajectory path = TestPath({{400, 0.4, 1.5 * kDeg}}, {1.45, 0}, Eigen::Quaterniond::Identity());
  const auto steps = StepsAlong(EveryFew(path));
  ASSERT_GT(steps.size(), 30U);
  for (const CameraStep& step : steps) {
    const TurningMotion motion = TurningMotionOf(step.previous_from_current, Eigen::Quaterniond::Identity());
    EXPECT_NEAR(motion.step * std::sin(motion.theta - 0.5 * motion.psi) / (2 * std::sin(0.5 * motion.psi)), 1.45,
                0.001);
  }
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
  EXPECT_EQ(RefusedField<StepOptions>([](StepOptions& o) { o.max_haste = 1; }), "max_haste");
  EXPECT_EQ(RefusedField<StepOptions>([](StepOptions& o) { o.speed_memory = 0; }), "speed_memory");
}

}  // namespace
}  // namespace turnscale
