// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/vehicle_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <random>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/synthetic_drive.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kIdentity = Eigen::Quaterniond::Identity();
constexpr double kDegree = 1 / kDegreesPerRadian;

Eigen::Quaterniond Pitched(double angle) { return RotationFromYawPitchRoll({0, angle, 0}); }

/// Where the camera of a car on a circle goes, drawn on paper: along the way that the car faces half-way through the
/// step, and to the right of it.
struct HalfWay {
  double forward = 0;
  double lateral = 0;
};
HalfWay SeenHalfWay(const AckermannStep& step, double lever_arm) {
  const auto heading = [](double angle) { return Eigen::Vector2d(std::sin(angle), std::cos(angle)); };  // east, north
  // The axle's chord lies half-way between its two headings.
  const Eigen::Vector2d camera_before = lever_arm * heading(0);
  const Eigen::Vector2d camera_after = step.rho * heading(0.5 * step.psi) + lever_arm * heading(step.psi);
  const Eigen::Vector2d ahead = heading(0.5 * step.psi);
  const Eigen::Vector2d right(ahead.y(), -ahead.x());
  return {(camera_after - camera_before).dot(ahead), (camera_after - camera_before).dot(right)};
}

Trajectory Timed(const std::vector<DriveSegment>& route, const LeverArm& lever_arm = {1.2, 0}) {
  Trajectory path;
  for (const RigidTransform& pose : MakeCarDrive(route, kStepInterval, lever_arm, kIdentity).world_from_camera)
    path.push_back({kStepInterval * static_cast<double>(path.size()), pose});
  return path;
}

Trajectory Straight(int poses) { return Timed({{poses - 1, 0.8, 0}}); }

std::vector<int> LastPoses(const std::vector<VehicleStep>& steps) {
  std::vector<int> last;
  for (const VehicleStep& step : steps) last.push_back(step.last);
  return last;
}

TEST(LevelStep, SeesTheCameraSwingAsTheGeometryHasIt) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const AckermannStep step{0.4 * uniform(random), 0.3 + std::abs(uniform(random))};
    const double lever_arm = 1.5 + uniform(random);
    const Eigen::Quaterniond mount =
        RotationFromYawPitchRoll({uniform(random), 0.4 * uniform(random), uniform(random)});
    const VehicleStep read = LevelStep(ConstrainedCameraMotion(step, lever_arm, mount), mount, 0.25, {});
    const HalfWay truth = SeenHalfWay(step, lever_arm);
    EXPECT_NEAR(read.lateral(), truth.lateral, 1e-12);
    EXPECT_NEAR(read.motion.step, std::hypot(truth.forward, truth.lateral), 1e-12);
    EXPECT_NEAR(read.motion.psi, step.psi, 1e-12);
    EXPECT_NEAR(read.speed(), 4 * read.motion.step, 1e-12);
    EXPECT_EQ(read.usable, std::abs(truth.lateral) <= std::sqrt(3.0) * truth.forward) << "60 deg";
  }
}

TEST(LevelStep, PitchOfTheMountDoesNotMatter) {
  std::mt19937 random(32);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const AckermannStep step{0.3 * uniform(random), 0.8};
    const double pitch = 0.3 * uniform(random);
    const RigidTransform motion = ConstrainedCameraMotion(step, 1.4, Pitched(pitch));
    const VehicleStep known = LevelStep(motion, Pitched(pitch), kStepInterval, {});
    for (const double believed : {0.0, 0.2, -0.35}) {
      const VehicleStep read = LevelStep(motion, Pitched(believed), kStepInterval, {});
      EXPECT_NEAR(read.motion.psi, known.motion.psi, 1e-12);
      EXPECT_NEAR(read.motion.theta, known.motion.theta, 1e-12);
      EXPECT_NEAR(read.lateral(), known.lateral(), 1e-12);
    }
    const double unlevelled = TurningMotionOf(motion, kIdentity).psi;
    if (std::abs(pitch) > 0.2 && std::abs(step.psi) > 0.1) {
      EXPECT_GT(std::abs(unlevelled - step.psi), 0.01 * std::abs(step.psi)) << "the pitch is worth levelling";
    }
  }
}

TEST(LevelStep, RollIsAboutTheWayThatTheStepGoes) {
  const Eigen::Quaterniond mount = RotationFromYawPitchRoll({0.2, -0.1, 0.05});
  for (const double roll : {0.01, -0.02}) {
    for (const double slope : {0.0, 0.1, -0.15}) {
      for (const double way : {1.0, -1.0}) {
        // The body turns about its own axes, which climb with the road; the camera sees the motion from its mount.
        const Eigen::Vector3d turn = Pitched(slope) * Eigen::Vector3d(0, 0.05, roll);
        const Eigen::Quaterniond rotation = RotationFromVector(turn);
        const Eigen::Vector3d travel = RotationFromVector(0.5 * turn) * (Pitched(slope) * Eigen::Vector3d(0, 0, way));
        const RigidTransform seen{mount.conjugate() * rotation * mount, mount.conjugate() * travel};
        EXPECT_NEAR(LevelStep(seen, mount, 0.1, {}).roll, roll, 1e-9) << "slope " << slope << ", way " << way;
      }
    }
  }
}

TEST(LevelStep, PitchOfTheMountIsNoRollInReverse) {
  for (const double pitch : {-0.2, 0.15}) {
    for (const double psi : {0.1, -0.1}) {
      const RigidTransform motion = ConstrainedCameraMotion({psi, -0.8}, 1.2, Pitched(pitch));
      const VehicleStep known = LevelStep(motion, Pitched(pitch), kStepInterval, {});
      const VehicleStep read = LevelStep(motion, kIdentity, kStepInterval, {});
      EXPECT_TRUE(read.usable);
      EXPECT_NEAR(read.roll, 0, 1e-12);
      EXPECT_NEAR(read.motion.psi, psi, 1e-12);
      EXPECT_NEAR(read.motion.theta, known.motion.theta, 1e-12);
      EXPECT_NEAR(read.lateral(), 1.2 * 2 * std::sin(0.5 * psi), 1e-12) << "the swing, as when it goes forward";
    }
  }
}

TEST(LevelStep, OnlyStepsAlongTheCarAreUsable) {
  const auto usable = [](const Eigen::Vector3d& travel) {
    return LevelStep({kIdentity, travel}, kIdentity, 0.1, {}).usable;
  };
  EXPECT_TRUE(usable({0, 0, 1}));
  EXPECT_TRUE(usable({std::sin(59 * kDegree), 0, std::cos(59 * kDegree)}));
  EXPECT_FALSE(usable({std::sin(61 * kDegree), 0, std::cos(61 * kDegree)}));
  EXPECT_FALSE(usable({0, -std::sin(61 * kDegree), std::cos(61 * kDegree)}));
  EXPECT_TRUE(usable({0, 0, -1})) << "in reverse";
  EXPECT_FALSE(usable({0, 0, 0}));
  EXPECT_FALSE(LevelStep({kIdentity, {0.5, 0, 1}}, kIdentity, 0.1, {.max_direction = 20 * kDegree}).usable);
}

TEST(LevelStep, WithoutTimesThereIsNoSpeed) {
  EXPECT_EQ(LevelStep({kIdentity, {0, 0, 1}}, kIdentity, 0, {}).speed(), 0);
}

TEST(CutIntoSteps, AStepEndsAtItsAngle) {
  // 1 deg from pose to pose: 3 poses reach 2.5 deg.
  const Trajectory path = Timed({{12, 0.4, -1 * kDegree}});
  const std::vector<VehicleStep> steps = CutIntoSteps(path, {}, true, {});
  EXPECT_EQ(LastPoses(steps), (std::vector<int>{3, 6, 9, 12}));
  for (const VehicleStep& step : steps) {
    EXPECT_NEAR(step.motion.psi, -3 * kDegree, 1e-9);
    EXPECT_NEAR(step.duration, 0.3, 1e-9);
    EXPECT_EQ(step.last - step.first, 3);
  }
  const std::vector<VehicleStep> finer = CutIntoSteps(path, {}, true, {.angle = 1.5 * kDegree});
  EXPECT_EQ(LastPoses(finer), (std::vector<int>{2, 4, 6, 8, 10, 12}));
}

TEST(CutIntoSteps, TheCameraSwingsAsTheLeverArmRequiresWhereTheCurvatureChanges) {
  const double lever_arm = 1.2;
  for (const double side : {1.0, -1.0}) {
    // Into the turn and out of it, on a circle from pose to pose, but not over a step.
    std::vector<DriveSegment> route;
    for (const double turn : {0.1, 0.3, 0.6, 0.9, 1.2, 1.2, 0.8, 0.4, 0.2, 0.1})
      route.push_back({1, 0.4, side * turn * kDegree});
    const std::vector<VehicleStep> steps = CutIntoSteps(Timed(route, {lever_arm, 0}), {}, true, {.max_duration = 10});
    ASSERT_EQ(LastPoses(steps), (std::vector<int>{5, 9, 10}));
    for (const VehicleStep& step : steps) {
      const double swing = lever_arm * 2 * std::sin(0.5 * step.motion.psi);
      EXPECT_NEAR(step.lateral(), swing, 2e-3 * std::abs(swing)) << step.last << ", " << side;
    }
    // In the axes half-way between the headings of both ends it is quite different.
    const TurningMotion& entry = steps.front().motion;
    EXPECT_GT(std::abs(entry.step * std::sin(entry.theta - 0.5 * entry.psi) - steps.front().lateral()),
              0.1 * std::abs(steps.front().lateral()));
  }
}

TEST(CutIntoSteps, TheSquaredSpeedIsWeightedByTurning) {
  // Braking while the car turns more and more, and less and less.
  for (const double side : {1.0, -1.0}) {
    for (const auto& turns : {std::array{0.002, 0.004, 0.008, 0.016}, std::array{0.016, 0.008, 0.004, 0.002}}) {
      constexpr std::array kWays = {1.0, 0.7, 0.4, 0.2};
      std::vector<DriveSegment> route;
      double integral = 0;
      double psi = 0;
      for (std::size_t i = 0; i < turns.size(); ++i) {
        route.push_back({1, kWays[i], side * turns[i]});
        integral += turns[i] * std::pow(kWays[i] / kStepInterval, 2);
        psi += turns[i];
      }
      const std::vector<VehicleStep> steps = CutIntoSteps(Timed(route), {}, true, {.angle = 0.03});
      ASSERT_EQ(LastPoses(steps), (std::vector<int>{4}));
      const double speed = steps[0].speed();
      EXPECT_NEAR(speed, 2.3 / (4 * kStepInterval), 0.01);
      EXPECT_NEAR(steps[0].square_speed_ratio, integral / (psi * speed * speed), 1e-9);
      EXPECT_GT(std::abs(std::log(steps[0].square_speed_ratio)), 0.3) << "not that of the mean speed";
    }
  }
  for (const VehicleStep& step : CutIntoSteps(Timed({{12, 0.4, 1 * kDegree}}), {}, true, {}))
    EXPECT_NEAR(step.square_speed_ratio, 1, 0.002) << "at an even speed";
}

TEST(CutIntoSteps, AnAngleOfZeroTakesEveryPose) {
  const std::vector<VehicleStep> steps = CutIntoSteps(Straight(6), {}, true, {.angle = 0});
  EXPECT_EQ(LastPoses(steps), (std::vector<int>{1, 2, 3, 4, 5}));
}

TEST(CutIntoSteps, AStraightStepEndsAfterItsTime) {
  Trajectory path = Straight(19);
  EXPECT_EQ(LastPoses(CutIntoSteps(path, {}, true, {})), (std::vector<int>{6, 12, 18}));
  EXPECT_EQ(LastPoses(CutIntoSteps(path, {}, true, {.max_duration = 0.3})), (std::vector<int>{3, 6, 9, 12, 15, 18}));
  // Times that were rounded to a hundredth do not shift the steps.
  std::mt19937 random(33);
  for (StampedPose& pose : path) pose.time += 0.001 * std::uniform_real_distribution<double>(-1, 1)(random);
  EXPECT_EQ(LastPoses(CutIntoSteps(path, {}, true, {})), (std::vector<int>{6, 12, 18}));
}

TEST(CutIntoSteps, WithoutTimesPosesAreCounted) {
  Trajectory path = Straight(9);
  for (StampedPose& pose : path) pose.time = 0;
  const std::vector<VehicleStep> steps = CutIntoSteps(path, {}, false, {.max_poses = 4});
  EXPECT_EQ(LastPoses(steps), (std::vector<int>{4, 8}));
  for (const VehicleStep& step : steps) EXPECT_EQ(step.duration, 0);
}

TEST(CutIntoSteps, WhatRemainsIsAStep) {
  Trajectory path = Straight(9);
  EXPECT_EQ(LastPoses(CutIntoSteps(path, {}, true, {})), (std::vector<int>{6, 8}));
  path[7].world_from_camera = path[8].world_from_camera = path[6].world_from_camera;
  const std::vector<VehicleStep> stands = CutIntoSteps(path, {}, true, {});
  EXPECT_EQ(LastPoses(stands), (std::vector<int>{6, 8})) << "every pose belongs to a step";
  EXPECT_TRUE(stands[0].usable);
  EXPECT_FALSE(stands[1].usable);
  EXPECT_TRUE(CutIntoSteps({path[0]}, {}, true, {}).empty());
  EXPECT_TRUE(CutIntoSteps({}, {}, true, {}).empty());
}

TEST(CutIntoSteps, NothingIsReadAcrossAGap) {
  Trajectory path = Straight(20);
  for (std::size_t i = 8; i < path.size(); ++i) {
    // Found again elsewhere, in another unit.
    path[i].world_from_camera.translation = Eigen::Vector3d(50, 1, 3) + 4 * path[i].world_from_camera.translation;
  }
  const std::vector<VehicleStep> steps = CutIntoSteps(path, {{8, 0.3}}, true, {});
  EXPECT_EQ(LastPoses(steps), (std::vector<int>{6, 7, 8, 14, 19}));
  int next = 0;
  for (const VehicleStep& step : steps) {
    EXPECT_EQ(step.first, next);
    next = step.last;
    EXPECT_EQ(step.after_gap, step.last == 8);
    EXPECT_EQ(step.usable, step.last != 8);
    EXPECT_EQ(step.gap_sigma, step.last == 8 ? 0.3 : 0);
    if (!step.after_gap) continue;
    EXPECT_EQ(step.motion.step, 0);
    EXPECT_EQ(step.motion.psi, 0);
    EXPECT_NEAR(step.duration, kStepInterval, 1e-9);
  }
}

TEST(CutIntoSteps, AGapWhereAStepEndsLeavesNoRest) {
  EXPECT_EQ(LastPoses(CutIntoSteps(Straight(14), {{7, 0.3}}, true, {})), (std::vector<int>{6, 7, 13}));
}

TEST(CutIntoSteps, AJumpIsNotUsable) {
  Trajectory path = Straight(43);
  for (std::size_t i = 15; i < path.size(); ++i) path[i].world_from_camera.translation.z() += 20;
  for (const VehicleStep& step : CutIntoSteps(path, {}, true, {})) EXPECT_EQ(step.usable, step.last != 18) << step.last;
  for (const VehicleStep& step : CutIntoSteps(path, {}, true, {.max_speed_ratio = 10})) EXPECT_TRUE(step.usable);
}

TEST(CutIntoSteps, AHoleInATurnShowsNothingOfTheCar) {
  // 3 deg from pose to pose; 1 s is missing.
  Trajectory path = Timed({{30, 0.4, 3 * kDegree}});
  path.erase(path.begin() + 10, path.begin() + 20);
  const std::vector<VehicleStep> steps = CutIntoSteps(path, {}, true, {});
  EXPECT_EQ(std::ranges::count_if(steps, [](const VehicleStep& step) { return !step.dense; }), 1);
  const auto hole = std::ranges::find_if(steps, [](const VehicleStep& step) { return !step.dense; });
  EXPECT_NEAR(hole->turned(), 33 * kDegree, 1e-9) << "the car turns there";
  EXPECT_GT(hole->driven(), 0);
  EXPECT_FALSE(hole->shows_kinematics());
  // The same poses without times, and the hole on a gentle bend.
  EXPECT_FALSE(std::ranges::all_of(CutIntoSteps(path, {}, false, {}), &VehicleStep::dense));
  Trajectory bend = Timed({{30, 0.4, 0.15 * kDegree}});
  bend.erase(bend.begin() + 10, bend.begin() + 20);
  EXPECT_TRUE(std::ranges::all_of(CutIntoSteps(bend, {}, true, {}), &VehicleStep::dense));
  // Two images a second in a sharp turn.
  Trajectory slow = Timed({{30, 0.4, 3 * kDegree}});
  for (StampedPose& pose : slow) pose.time *= 5;
  EXPECT_TRUE(std::ranges::all_of(CutIntoSteps(slow, {}, true, {}), &VehicleStep::dense));
}

TEST(CutIntoSteps, AHoleWhereATurnMayBeginShowsNothingOfTheCar) {
  // 5.5 deg in the 1.1 s across the hole, where the path may be straight and then turn.
  const Trajectory whole = Timed({{60, 0.4, 0.5 * kDegree}});
  Trajectory path = whole;
  path.erase(path.begin() + 20, path.begin() + 30);
  const std::vector<VehicleStep> steps = CutIntoSteps(path, {}, true, {});
  EXPECT_EQ(std::ranges::count_if(steps, [](const VehicleStep& step) { return !step.dense; }), 1);
  // Poses that are all so far apart are those of a slow camera in a bend.
  Trajectory slow;
  for (std::size_t i = 0; i < whole.size(); i += 11) slow.push_back(whole[i]);
  EXPECT_TRUE(std::ranges::all_of(CutIntoSteps(slow, {}, true, {}), &VehicleStep::dense));
}

TEST(CutIntoSteps, AFastRoadIsNoJump) {
  // A third of the steps at 2.5 times the speed of the others.
  const std::vector<VehicleStep> steps = CutIntoSteps(Timed({{60, 0.6, 0}, {30, 1.5, 0}}), {}, true, {});
  EXPECT_TRUE(std::ranges::all_of(steps, &VehicleStep::usable));
}

TEST(CutIntoSteps, TooShortAPathShowsNoJump) {
  Trajectory path = Straight(13);
  for (std::size_t i = 7; i < path.size(); ++i) path[i].world_from_camera.translation.z() += 50;
  for (const VehicleStep& step : CutIntoSteps(path, {}, true, {})) EXPECT_TRUE(step.usable);
}

TEST(StepBuilder, PoseByPoseIsTheWholePath) {
  const Trajectory path =
      Timed({{25, 0.9, 0}, {30, 0.5, 2 * kDegree}, {17, 0.8, 0.3 * kDegree}, {20, 0.4, -3 * kDegree}});
  const std::vector<PathGap> gaps{{13, 0.2}, {14, 0.3}, {40, 0.1}};
  for (const bool timed : {true, false}) {
    StepBuilder builder({}, timed);
    std::vector<VehicleStep> steps;
    auto gap = gaps.begin();
    for (std::size_t i = 0; i < path.size(); ++i) {
      std::optional<double> gap_sigma;
      if (gap != gaps.end() && gap->pose == static_cast<int>(i)) gap_sigma = (gap++)->sigma;
      const std::vector<VehicleStep> ended = builder.Add(path[i], gap_sigma);
      EXPECT_LE(ended.size(), gap_sigma ? 2u : 1u);
      for (const VehicleStep& step : ended) EXPECT_EQ(step.last, &step == &ended.back() ? i : i - 1);
      std::ranges::copy(ended, std::back_inserter(steps));
    }
    if (const auto rest = builder.Finish()) steps.push_back(*rest);
    EXPECT_FALSE(builder.Finish()) << "the path ends once";
    const std::vector<VehicleStep> batch = CutIntoSteps(path, gaps, timed, {});
    ASSERT_EQ(steps.size(), batch.size());
    for (std::size_t i = 0; i < steps.size(); ++i) {
      EXPECT_EQ(steps[i].first, batch[i].first);
      EXPECT_EQ(steps[i].last, batch[i].last);
      EXPECT_EQ(steps[i].motion.psi, batch[i].motion.psi);
      EXPECT_EQ(steps[i].lateral(), batch[i].lateral());
      EXPECT_EQ(steps[i].roll, batch[i].roll);
      EXPECT_EQ(steps[i].square_speed_ratio, batch[i].square_speed_ratio);
      EXPECT_EQ(steps[i].duration, batch[i].duration);
      EXPECT_EQ(steps[i].after_gap, batch[i].after_gap);
      EXPECT_EQ(steps[i].gap_sigma, batch[i].gap_sigma);
    }
  }
}

TEST(StepBuilder, AxesMayTurnWithinAStep) {
  const Eigen::Quaterniond old_from_new = RotationFromYawPitchRoll({2 * kDegree, -1 * kDegree, 0.5 * kDegree});
  const Trajectory path = Timed({{6, 0.8, 0}, {12, 0.4, 1 * kDegree}});
  Trajectory turned = path;
  for (StampedPose& pose : turned) pose.world_from_camera.rotation = pose.world_from_camera.rotation * old_from_new;
  StepBuilder builder({}, true);
  std::vector<VehicleStep> steps;
  constexpr std::size_t kChange = 8;  // in the middle of a step
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i == kChange) {
      steps.clear();
      builder.TurnAxes(old_from_new);
    }
    std::ranges::copy(builder.Add(i < kChange ? path[i] : turned[i]), std::back_inserter(steps));
  }
  std::vector<VehicleStep> expected = CutIntoSteps(turned, {}, true, {});
  std::erase_if(expected, [&](const VehicleStep& step) { return step.last < static_cast<int>(kChange); });
  ASSERT_GE(steps.size(), 2U);
  ASSERT_LT(steps.front().first, static_cast<int>(kChange));
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].first, expected[i].first);
    EXPECT_NEAR(steps[i].motion.psi, expected[i].motion.psi, 1e-12);
    EXPECT_NEAR(steps[i].motion.theta, expected[i].motion.theta, 1e-12);
  }
}

TEST(CutIntoSteps, StepsLeadPastAPoseThatIsNotFinite) {
  Trajectory path = Timed({{6, 0.8, 0}, {12, 0.4, 1 * kDegree}});
  const std::vector<VehicleStep> all = CutIntoSteps(path, {}, true, {});
  ASSERT_EQ(LastPoses(all), (std::vector<int>{6, 9, 12, 15, 18}));
  for (const int i : {0, 3}) path[i].world_from_camera.translation.x() = std::nan("");
  path[8].world_from_camera.rotation.w() = HUGE_VAL;
  const std::vector<VehicleStep> steps = CutIntoSteps(path, {}, true, {});
  ASSERT_EQ(LastPoses(steps), (std::vector<int>{7, 10, 13, 16, 18}));
  EXPECT_EQ(steps.front().first, 1);
  for (std::size_t i = 1; i + 1 < steps.size(); ++i) {
    EXPECT_EQ(steps[i].first, steps[i - 1].last);
    EXPECT_NEAR(steps[i].motion.psi, all[i].motion.psi, 1e-12);
    EXPECT_NEAR(steps[i].lateral(), all[i].lateral(), 1e-6);
    EXPECT_NEAR(steps[i].duration, all[i].duration, 1e-12);
    EXPECT_NEAR(steps[i].square_speed_ratio, all[i].square_speed_ratio, 1e-3);
  }
}

TEST(CutIntoSteps, AGapBeforeAPoseThatIsNotFiniteIsOneBeforeTheNext) {
  Trajectory path = Straight(14);
  for (const int i : {8, 9}) path[i].world_from_camera.translation.x() = std::nan("");
  const std::vector<VehicleStep> steps = CutIntoSteps(path, {{8, 0.3}}, true, {});
  ASSERT_EQ(LastPoses(steps), (std::vector<int>{6, 9, 10, 13}));
  for (const VehicleStep& step : steps) {
    EXPECT_EQ(step.after_gap, step.last == 10);
    EXPECT_EQ(step.gap_sigma, step.last == 10 ? 0.3 : 0);
  }
}

TEST(VehicleStepOptions, RefusesSenselessValues) {
  const auto refused = [](auto change) { return RefusedField<VehicleStepOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.angle = -0.1; }), "angle_deg");
  EXPECT_EQ(refused([](auto& o) { o.angle = 0.5; }), "angle_deg");
  EXPECT_EQ(refused([](auto& o) { o.max_duration = 0; }), "max_duration");
  EXPECT_EQ(refused([](auto& o) { o.max_poses = 0; }), "max_poses");
  EXPECT_EQ(refused([](auto& o) { o.max_pose_interval = 0; }), "max_pose_interval");
  EXPECT_EQ(refused([](auto& o) { o.max_pose_turn = 0; }), "max_pose_turn_deg");
  EXPECT_EQ(refused([](auto& o) { o.max_isolated_turn = 0; }), "max_isolated_turn_deg");
  EXPECT_EQ(refused([](auto& o) { o.max_speed_ratio = 1; }), "max_speed_ratio");
  EXPECT_EQ(refused([](auto& o) { o.max_direction = 0; }), "max_direction_deg");
}

}  // namespace
}  // namespace turnscale
