// SPDX-License-Identifier: MIT
#include "turnscale/odometry/drive_scale.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/synthetic_drive.h"
#include "turnscale/odometry/drive_steps.h"
#include "turnscale/odometry/test_corners.h"

namespace turnscale {
namespace {

constexpr double kUnits = 0.3;  // of the map, per metre

// Of kTwoCorners.
constexpr int kFirstCorner = 12;   // the keyframe where it begins
constexpr int kSecondCorner = 59;  // likewise

std::vector<RigidTransform> TrueDrive(const std::vector<DriveSegment>& segments,
                                      const Eigen::Quaterniond& mount = kMounting) {
  return MakeCarDrive(segments, 0.1, {kLeverArm, OdometryOptions().vehicle.side_slip}, mount).world_from_camera;
}

/// A drive as the odometry lives it: keyframe by keyframe, in the unit of its start.
struct Live {
  std::vector<RigidTransform> truth;
  double units_per_metre = 1;
  double noise = 0;        ///< of a centre, metres
  int reach = 0;           ///< keyframes that are read again when a turn ends; 0: all
  int delay = 0;           ///< keyframes from the end of a turn until they are read again
  double drift = 0;        ///< of the unit, over 100 m, relative
  std::optional<int> end;  ///< number of keyframes when a turn ended that is not read again yet
  Random random{5};
  Map map;
  DriveScale scale;

  Live(const OdometryOptions& options, const std::vector<RigidTransform>& world_from_camera, double units,
       double position_noise = 0)
      : truth(world_from_camera), units_per_metre(units), noise(position_noise), scale(options) {}

  /// The next keyframe. `gap` is the factor by which the unit changes across a loss of tracking.
  void Next(double gap = 1) {
    Append(gap);
    const int k = CountKeyframes(map) - 1;
    // The camera's rotation is learnt where a turn ends, as Odometry does it.
    if (scale.Add(map) && !end) end = k + 1;
    if (!end || k + 1 < *end + delay) return;
    const int final_before = reach == 0 ? 0 : k + 1 - reach;
    MountCalibration mount = scale.mount();
    mount.Learn(map, k);
    scale.Reread(map, std::move(mount), {std::max(0, final_before), *end, final_before});
    end.reset();
  }

  /// The same, not read yet.
  void Append(double gap = 1) {
    const int k = CountKeyframes(map);
    Keyframe keyframe{.frame = 2 * k, .time = 0.1 * k, .camera_from_world = {}, .observations = {}};
    if (k > 0) {
      RigidTransform step = truth[k].inverse() * truth[k - 1];
      for (int i = 0; i < 3; ++i) step.translation[i] += noise * random.Gaussian();
      if (drift > 0) units_per_metre *= std::exp(drift * std::sqrt(TrueStep(k) / 100) * random.Gaussian());
      if (gap != 1) {
        keyframe.after_gap = true;
        keyframe.gap_sigma = 0.3;
        units_per_metre *= gap;
      }
      step.translation *= units_per_metre;
      keyframe.camera_from_world = step * map.keyframes.back().camera_from_world;
    }
    map.keyframes.push_back(keyframe);
  }

  void Drive() {
    while (map.keyframes.size() < truth.size()) Next();
  }

  double TrueStep(int k) const { return (truth[k].translation - truth[k - 1].translation).norm(); }
  double MapStep(int k) const { return (Centre(map.keyframes[k]) - Centre(map.keyframes[k - 1])).norm(); }
};

double StepOf(const MetricPath& path, int k) { return (path.centres[k] - path.centres[k - 1]).norm(); }

void ExpectSameMap(const Map& a, const Map& b) {
  ASSERT_EQ(a.keyframes.size(), b.keyframes.size());
  for (std::size_t k = 0; k < a.keyframes.size(); ++k) {
    EXPECT_EQ(a.keyframes[k].camera_from_world.translation, b.keyframes[k].camera_from_world.translation);
    EXPECT_EQ(a.keyframes[k].camera_from_world.rotation.coeffs(), b.keyframes[k].camera_from_world.rotation.coeffs());
  }
  ASSERT_EQ(a.landmarks.size(), b.landmarks.size());
  for (std::size_t i = 0; i < a.landmarks.size(); ++i) EXPECT_EQ(a.landmarks[i].position, b.landmarks[i].position);
}

TEST(DriveScale, TwoCornersGiveMetres) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), kUnits, 0.001);
  live.Drive();
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_TRUE(refined.estimate) << refined.reason;
  EXPECT_EQ(refined.reason, "");
  const std::vector<TurnResult>& turns = refined.turns;
  ASSERT_EQ(turns.size(), 2U);
  for (const TurnResult& turn : turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_EQ(turn.reason, "");
    EXPECT_EQ(turn.unadjusted, "");
    EXPECT_NEAR(turn.own * kUnits, 1, 0.01);
    EXPECT_NEAR(turn.as_given * kUnits, 1, 0.01);
    EXPECT_NEAR(turn.smoothed * kUnits, 1, 0.005);
    EXPECT_NEAR(turn.effective_lever_arm, kLeverArm - kUsualSideSlip * 36, 0.01);
    EXPECT_NEAR(turn.speed, 6, 0.03);
    EXPECT_GT(turn.own_sigma, 0);
    EXPECT_GT(turn.smoothed_sigma, 0);
    EXPECT_EQ(turn.first_frame, 2 * turn.first_keyframe);
    EXPECT_EQ(turn.last_frame, 2 * turn.last_keyframe);
  }
  EXPECT_NEAR(turns[0].first_keyframe, kFirstCorner, 1);
  EXPECT_NEAR(turns[0].last_keyframe, kFirstCorner + 22, 1);
  EXPECT_NEAR(turns[0].angle, M_PI / 2, 1e-4);
  EXPECT_NEAR(turns[1].angle, -M_PI / 2, 1e-4);
  EXPECT_NEAR(turns[1].first_keyframe, kSecondCorner, 1);
  for (int k = 1; k < CountKeyframes(live.map); ++k) {
    EXPECT_NEAR(StepOf(refined.path, k) / live.TrueStep(k), 1, 0.012) << k;
    EXPECT_NEAR(refined.path.metres_per_unit[k] * kUnits, 1, 0.005) << k;
    EXPECT_LT(refined.keyframes[k].sigma, 0.08);
  }
  EXPECT_EQ(live.scale.state(), ScaleState::kObserved) << "a turn ends a second after its last strong step";
  EXPECT_LT(live.scale.sigma(), 0.08);
}

TEST(DriveScale, GivesMetresInsideTheFirstTurn) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), kUnits, 0.002);
  int known_at = -1;
  while (CountKeyframes(live.map) <= kFirstCorner + 22) {
    live.Next();
    const int k = CountKeyframes(live.map) - 1;
    const MetricPath& path = live.scale.live_path();
    ASSERT_EQ(path.centres.size(), live.map.keyframes.size());
    if (live.scale.state() == ScaleState::kPending) {
      EXPECT_EQ(known_at, -1);
      EXPECT_TRUE(std::isinf(live.scale.sigma()));
      EXPECT_EQ(path.metres_per_unit[k], 1);
      EXPECT_LT((path.centres[k] - Centre(live.map.keyframes[k])).norm(), 1e-12) << "the map's own unit";
      continue;
    }
    EXPECT_EQ(live.scale.state(), ScaleState::kObserved);
    if (known_at < 0) {
      known_at = k;
      for (int i = 1; i <= k; ++i)
        EXPECT_NEAR(std::log(StepOf(path, i) / (live.MapStep(i) / kUnits)), 0, 0.5 * live.scale.sigma())
            << "all of the path becomes metric";
    }
    EXPECT_LE(live.scale.sigma(), 0.15);
  }
  EXPECT_GT(known_at, kFirstCorner + 3);
  EXPECT_LT(known_at, kFirstCorner + 15);
}

TEST(DriveScale, NeverTouchesTheMap) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), kUnits, 0.002);
  live.map.landmarks.push_back({{1, 2, 3}, true, {}});
  while (live.map.keyframes.size() < live.truth.size()) {
    Map before = live.map;
    live.Next();
    Map after = live.map;
    after.keyframes.pop_back();
    ExpectSameMap(before, after);
  }
  const Map before = live.map;
  live.scale.Reread(live.map);
  const RefinedScale once = live.scale.Refine(live.map);
  ExpectSameMap(before, live.map);
  const RefinedScale twice = live.scale.Refine(live.map);
  for (std::size_t k = 0; k < before.keyframes.size(); ++k) EXPECT_EQ(once.path.centres[k], twice.path.centres[k]);
}

TEST(DriveScale, TheArbitraryUnitDoesNotMatter) {
  Live one(KnownCar(), TrueDrive(kTwoCorners), 1, 0.002);
  one.Drive();
  const RefinedScale refined = one.scale.Refine(one.map);
  for (const double unit : {0.02, 10.0}) {
    Live other(KnownCar(), TrueDrive(kTwoCorners), unit, 0.002);
    other.Drive();
    const RefinedScale in_other = other.scale.Refine(other.map);
    for (int k = 1; k < CountKeyframes(one.map); ++k) {
      EXPECT_NEAR(StepOf(in_other.path, k) / StepOf(refined.path, k), 1, 1e-6) << unit << ' ' << k;
      EXPECT_NEAR(StepOf(other.scale.live_path(), k) / StepOf(one.scale.live_path(), k), 1, 1e-6) << unit << ' ' << k;
    }
    for (const int turn : {0, 1}) EXPECT_NEAR(in_other.turns[turn].own * unit / refined.turns[turn].own, 1, 1e-6);
    EXPECT_NEAR(other.scale.sigma() / one.scale.sigma(), 1, 1e-5);
  }
}

// What was driven before the last turn does not change any more, and no step is out of line with its scale.
class GrowingLivePath : public testing::TestWithParam<int> {};

TEST_P(GrowingLivePath, GrowsAtItsEnd) {
  std::vector<DriveSegment> route;
  for (int i = 0; i < 4; ++i) {
    route.push_back({60, 0.8, 0});
    route.push_back({22, 0.6, i % 2 == 0 ? kCornerStep : -kCornerStep});
  }
  route.push_back({60, 0.8, 0});
  Live live(KnownCar(), TrueDrive(route), kUnits, 0.002);
  live.delay = GetParam();
  MetricPath before;
  while (live.map.keyframes.size() < live.truth.size()) {
    const int turn_end = live.scale.last_turn_end();
    const bool known = live.scale.state() != ScaleState::kPending;
    live.Next();
    const MetricPath& path = live.scale.live_path();
    const int count = static_cast<int>(path.centres.size());
    for (int k = 0; known && k <= turn_end; ++k) {
      EXPECT_EQ(path.metres_per_unit[k], before.metres_per_unit[k]);
      EXPECT_LT((path.centres[k] - before.centres[k]).norm(), 1e-9);
    }
    for (int k = 1; k < count; ++k) {
      EXPECT_NEAR(StepOf(path, k) / live.MapStep(k), path.metres_per_unit[k], 1e-6) << k;
      if (known) {
        EXPECT_NEAR(path.metres_per_unit[k] / path.metres_per_unit[k - 1], 1, 5e-4) << "no jump between turns";
      }
    }
    before = path;
  }
  EXPECT_EQ(live.scale.last_turn_end(), 4 * 82 + 12) << "two straight steps of 0.6 s make sure of the turn's end";
  for (int k = 1; k < CountKeyframes(live.map); ++k)
    EXPECT_NEAR(StepOf(live.scale.live_path(), k) / live.TrueStep(k), 1, 0.02) << k;
}

INSTANTIATE_TEST_SUITE_P(KeyframesUntilATurnIsReadAgain, GrowingLivePath, testing::Values(0, 6));

// Three kilometres with forty corners, along which the unit drifts as much as odometry is taken to.
TEST(DriveScale, ALongDriveStaysInMetres) {
  constexpr int kCorners = 40;
  std::vector<DriveSegment> route = {{60, 0.8, 0}};
  for (int i = 0; i < kCorners; ++i) {
    route.push_back({22, 0.6, i % 3 == 0 ? -kCornerStep : kCornerStep});
    route.push_back({50 + 7 * (i % 8), 0.8, 0});
  }
  OdometryOptions options = KnownCar();
  options.vehicle.lever_arm_sigma = 0;
  options.vehicle.side_slip_sigma = 0;
  Live live(options, TrueDrive(route), kUnits, 0.002);
  live.drift = ScaleEstimatorOptions().drift.per_100m;
  std::vector<double> units;
  int turn_ends = 0;
  while (live.map.keyframes.size() < live.truth.size()) {
    const int before = live.scale.last_turn_end();
    live.Next();
    units.push_back(live.units_per_metre);
    if (turn_ends > 0) {
      EXPECT_LT(live.scale.sigma(), 0.065) << "however long the drive is";
    }
    if (live.scale.last_turn_end() == before) continue;
    ++turn_ends;
    const double error = std::log(live.scale.live_path().metres_per_unit.back() * live.units_per_metre);
    EXPECT_LT(std::abs(error), 2 * live.scale.sigma()) << "turn " << turn_ends;
  }
  EXPECT_EQ(turn_ends, kCorners);
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_TRUE(refined.estimate) << refined.reason;
  EXPECT_FALSE(refined.estimate->uses_single_turns);
  EXPECT_EQ(refined.turns.size(), static_cast<std::size_t>(kCorners));
  double length = 0;
  double truth = 0;
  double worst = 0;
  for (int k = 1; k < static_cast<int>(units.size()); ++k) {
    length += StepOf(refined.path, k);
    truth += live.TrueStep(k);
    worst = std::max(worst, std::abs(std::log(refined.path.metres_per_unit[k] * units[k])));
  }
  EXPECT_GT(truth, 2900);
  EXPECT_NEAR(length / truth, 1, 0.005);
  EXPECT_LT(worst, 0.05);
  EXPECT_LT(std::abs(std::log(length / truth)), 2 * refined.estimate->length_sigma);
  EXPECT_LT(refined.estimate->length_sigma, 0.01) << "better than any turn by itself";
}

TEST(DriveScale, FindsTheMountAndReadsTheTurnsBeforeAgain) {
  OdometryOptions options = KnownCar();
  options.vehicle.vehicle_from_camera = Eigen::Quaterniond::Identity();
  Live assumed(options, TrueDrive(kTwoCorners), kUnits);
  assumed.Drive();
  const RefinedScale off = assumed.scale.Refine(assumed.map);
  ASSERT_TRUE(off.estimate->yaw_conflict) << "1.7 deg";
  EXPECT_NEAR(off.turns[0].as_given * kUnits, 1, 0.01) << "single-turn scales have the yaw of the drive then";

  options.vehicle.calibrate_camera = true;
  Live live(options, TrueDrive(kTwoCorners), kUnits);
  live.Drive();
  EXPECT_LT(live.scale.mount().current().vehicle_from_camera.angularDistance(kMounting), 1e-4 / kDegreesPerRadian);
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_EQ(refined.turns.size(), 2U);
  for (const TurnResult& turn : refined.turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    // A step across the end of a corner is no single circle.
    EXPECT_NEAR(turn.own * kUnits, 1, 2e-4);
  }
  for (int k = 1; k < CountKeyframes(live.map); ++k)
    EXPECT_NEAR(StepOf(refined.path, k) / live.TrueStep(k), 1, 1e-4) << k;
  EXPECT_NEAR(live.scale.live_path().metres_per_unit.back() * kUnits, 1, 1e-4);
}

TEST(DriveScale, ATurnThatOnlyTheMountExplainsIsUsedOnceItIsKnown) {
  OdometryOptions options = KnownCar();
  // So far off that no turn to one side can be read.
  options.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.03 + 0.3, -0.05, 0.01});
  options.vehicle.side_slip_sigma = 0;
  // Else the yaw is found from the straights.
  options.scale.estimator.max_yaw_deviation = 1e9;
  Live assumed(options, TrueDrive(kTwoCorners), 1);
  assumed.Drive();
  const std::vector<TurnResult> unread = assumed.scale.Refine(assumed.map).turns;
  EXPECT_TRUE(!unread[0].used || !unread[1].used);

  options.vehicle.calibrate_camera = true;
  Live live(options, TrueDrive(kTwoCorners), 1);
  live.Drive();
  EXPECT_EQ(live.scale.state(), ScaleState::kObserved) << "a turn ends a second after its last strong step";
  for (const TurnResult& turn : live.scale.Refine(live.map).turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_EQ(turn.reason, "");
    EXPECT_NEAR(turn.own, 1, 2e-4);
  }
}

// Five corners, after which the camera is turned, and five more. `at`: the last keyframe before the move.
struct MovedDrive {
  std::vector<RigidTransform> drive;
  int at = 0;
};

MovedDrive DriveWithMovedCamera() {
  std::vector<DriveSegment> blocks = {{40, 0.8, 0}};
  for (int i = 0; i < 5; ++i) {
    blocks.push_back({30, 0.6, i % 2 == 0 ? M_PI / 60 : -M_PI / 60});
    blocks.push_back({40, 0.8, 0});
  }
  const Eigen::Quaterniond moved = RotationFromYawPitchRoll({0.03 + 0.06, -0.05 + 0.03, 0.01});
  std::vector<RigidTransform> drive = TrueDrive(blocks);
  const int at = static_cast<int>(drive.size()) - 1;
  const RigidTransform pose = drive.back();
  for (const RigidTransform& next : TrueDrive(blocks, moved)) {
    // The car goes on as it stood; its camera has turned.
    const RigidTransform turned{pose.rotation * kMounting.conjugate() * moved, pose.translation};
    if (next.translation.norm() > 0) drive.push_back(turned * next);
  }
  return {drive, at};
}

TEST(DriveScale, EachStepIsReadAsTheCameraWasTurnedThen) {
  const auto [drive, at] = DriveWithMovedCamera();
  OdometryOptions options = KnownCar();
  options.vehicle.calibrate_camera = true;
  Live live(options, drive, kUnits);
  live.Drive();
  EXPECT_EQ(live.scale.mount().moves(), 1);
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_TRUE(refined.estimate) << refined.reason;
  EXPECT_FALSE(refined.estimate->uses_single_turns);
  ASSERT_EQ(refined.turns.size(), 10U);
  for (const TurnResult& turn : refined.turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_NEAR(turn.own * kUnits, 1, 7e-4) << turn.first_keyframe - at;
  }
}

TEST(DriveScale, HeightsFromAfterAMoveOfTheCameraAreNotUsed) {
  const std::vector<RigidTransform> drive = DriveWithMovedCamera().drive;
  OdometryOptions options = KnownCar();
  options.vehicle.calibrate_camera = true;
  // The camera is lower after the move, from keyframe `moved` on; heights are measured before `end`.
  const auto driven = [&](int moved, int end) {
    Live live(options, drive, kUnits);
    while (live.map.keyframes.size() < drive.size()) {
      const int k = CountKeyframes(live.map);
      if (k > 0 && k < end) {
        RigidTransform step = drive[k - 1].inverse() * drive[k];
        step.translation *= kUnits;
        const double height = (k < moved ? 1.5 : 1.2) * kUnits;
        live.scale.AddHeight({k, k - 1, height / step.translation.norm(), 0.02, step, {}, {}});
      }
      live.Next();
    }
    return live;
  };
  const int all = static_cast<int>(drive.size());
  const Live without = driven(all, 0);
  ASSERT_EQ(without.scale.mount().moves(), 1);
  const int moved = without.scale.mount().mounts()[1].first_keyframe;
  const Live before = driven(moved, moved);
  const Live both = driven(moved, all);
  const RefinedScale of_before = before.scale.Refine(before.map);
  const RefinedScale of_both = both.scale.Refine(both.map);
  EXPECT_NE(without.scale.Refine(without.map).path.metres_per_unit, of_before.path.metres_per_unit);
  EXPECT_EQ(of_both.path.metres_per_unit, of_before.path.metres_per_unit);
  EXPECT_EQ(of_both.keyframes, of_before.keyframes);
}

TEST(DriveScale, AJumpOfTheCameraIsNoMotionOfTheCar) {
  const Eigen::Quaterniond jump = RotationFromYawPitchRoll({0.02, 0, 0});
  constexpr int kAt = 100;
  std::vector<RigidTransform> drive =
      TrueDrive({{40, 0.8, 0}, {30, 0.6, M_PI / 60}, {40, 0.8, 0}, {30, 0.6, -M_PI / 60}, {40, 0.8, 0}});
  for (size_t i = kAt; i < drive.size(); ++i) drive[i].rotation = drive[i].rotation * jump;
  Live live(KnownCar(), drive, kUnits);
  while (live.map.keyframes.size() < drive.size()) {
    live.Next();
    if (CountKeyframes(live.map) != kAt + 3) continue;
    live.scale.Reread(live.map);
    live.scale.AddJump(live.map, kAt, {.first_frame = kAt, .before_from_after = jump});
    // The turn before it has been re-evaluated: it does not change the live path again.
    const std::vector<double> scales = live.scale.live_path().metres_per_unit;
    live.scale.Reread(live.map, live.scale.mount(), {.first = kAt - 10, .end = kAt, .final_before = 0});
    EXPECT_EQ(live.scale.live_path().metres_per_unit, scales);
  }
  EXPECT_NEAR(InDegrees(StepMotion(live.map, kAt - 1, live.scale.mount()).psi), 0, 1e-6);
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_TRUE(refined.estimate) << refined.reason;
  ASSERT_EQ(refined.turns.size(), 2U);
  for (const TurnResult& turn : refined.turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_NEAR(turn.own * kUnits, 1, 7e-4) << turn.first_keyframe;
  }
}

TEST(DriveScale, AllTurnsTogetherTellWhatTheYawHasWrong) {
  OdometryOptions options = KnownCar();
  options.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.03 - 0.01, -0.05, 0.01});
  std::vector<DriveSegment> route = {{12, 0.8, 0}};
  for (int i = 0; i < 6; ++i) {
    route.push_back({22, 0.6, i % 2 == 0 ? kCornerStep : -kCornerStep});
    route.push_back({30, 0.8, 0});
  }
  Live live(options, TrueDrive(route), kUnits);
  live.Drive();
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_TRUE(refined.estimate);
  EXPECT_NEAR(refined.estimate->car.yaw_error, 0.01, 6e-4);
  double as_given = 0;
  double smoothed = 0;
  for (const TurnResult& turn : refined.turns) {
    as_given = std::max(as_given, std::abs(std::log(turn.as_given * kUnits)));
    smoothed = std::max(smoothed, std::abs(std::log(turn.smoothed * kUnits)));
  }
  EXPECT_LT(smoothed, 0.03 * as_given) << "right and left turns disagree; together they show it";
}

TEST(DriveScale, ReadingTheLatestPartAgainIsEnough) {
  std::vector<DriveSegment> segments;
  for (int i = 0; i < 12; ++i) {
    segments.push_back({40, 0.8, 0});
    segments.push_back({22, 0.6, i % 3 == 1 ? -kCornerStep : kCornerStep});
  }
  OdometryOptions options;
  options.vehicle.lever_arm = kLeverArm;
  Live whole(options, TrueDrive(segments), kUnits, 0.0005);
  Live part(options, TrueDrive(segments), kUnits, 0.0005);
  part.reach = 120;
  while (whole.map.keyframes.size() < whole.truth.size()) {
    whole.Next();
    part.Next();
    ASSERT_EQ(part.scale.state(), whole.scale.state()) << whole.map.keyframes.size();
    if (whole.scale.state() == ScaleState::kPending) continue;
    EXPECT_NEAR(part.scale.live_path().metres_per_unit.back() / whole.scale.live_path().metres_per_unit.back(), 1, 0.01)
        << whole.map.keyframes.size();
    EXPECT_NEAR(part.scale.sigma() / whole.scale.sigma(), 1, 0.1) << whole.map.keyframes.size();
  }
  EXPECT_EQ(whole.scale.state(), ScaleState::kObserved);
  EXPECT_TRUE(whole.scale.mount().current().found);
}

TEST(DriveScale, ATurnIsReadAgainThoughAnotherHasEndedMeanwhile) {
  std::vector<DriveSegment> segments = kTwoCorners;
  segments.push_back({40, 0.8, 0});
  Live live(KnownCar(), TrueDrive(segments), kUnits);
  live.delay = 60;
  live.Drive();
  ASSERT_EQ(live.scale.Refine(live.map).turns.size(), 2U);
  EXPECT_GE(live.scale.last_turn_end(), kFirstCorner + 22);
  EXPECT_LT(live.scale.last_turn_end(), kSecondCorner) << "the second turn waits";
}

TEST(DriveScale, StaysPendingWithoutALeverArm) {
  OdometryOptions options = KnownCar();
  options.vehicle.lever_arm.reset();
  Live live(options, TrueDrive(kTwoCorners), kUnits);
  int turn_ends = 0;
  while (live.map.keyframes.size() < live.truth.size()) {
    const int before = live.scale.last_turn_end();
    live.Next();
    turn_ends += live.scale.last_turn_end() != before;
    EXPECT_EQ(live.scale.state(), ScaleState::kPending);
  }
  EXPECT_EQ(turn_ends, 2) << "turns are found all the same";
  EXPECT_TRUE(std::isinf(live.scale.sigma()));
  const RefinedScale refined = live.scale.Refine(live.map);
  EXPECT_FALSE(refined.estimate);
  EXPECT_EQ(refined.reason, "no lever arm given");
  ASSERT_EQ(refined.turns.size(), 2U);
  for (const TurnResult& turn : refined.turns) {
    EXPECT_FALSE(turn.used);
    EXPECT_EQ(turn.reason, "no lever arm given");
    EXPECT_EQ(turn.own, 0);
    EXPECT_NEAR(std::abs(turn.angle), M_PI / 2, 1e-4) << "the turn itself is seen";
  }
  for (std::size_t k = 0; k < live.map.keyframes.size(); ++k) {
    EXPECT_EQ(refined.path.centres[k], Centre(live.map.keyframes[k]));
    EXPECT_EQ(refined.path.metres_per_unit[k], 1);
    EXPECT_TRUE(std::isinf(refined.keyframes[k].sigma));
  }
}

TEST(DriveScale, ATurnThatTellsNothingSaysWhy) {
  // At 20 m/s the slip of the tyres exceeds the lever arm.
  Live live(KnownCar(), TrueDrive({{20, 2, 0}, {12, 2, 0.05}, {20, 2, 0}}), 1);
  live.Drive();
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_EQ(refined.turns.size(), 1U);
  EXPECT_FALSE(refined.turns[0].used);
  EXPECT_NE(refined.turns[0].reason, "");
  EXPECT_FALSE(refined.estimate);
  EXPECT_NE(refined.reason, "");
  EXPECT_EQ(live.scale.state(), ScaleState::kPending);
}

TEST(DriveScale, ATurnThatIsStillOpenClosesAtTheEnd) {
  Live live(KnownCar(), TrueDrive({{12, 0.8, 0}, {22, 0.6, kCornerStep}}), 4);
  live.Drive();
  live.scale.Reread(live.map);
  EXPECT_EQ(live.scale.state(), ScaleState::kObserved);
  EXPECT_NEAR(live.scale.live_path().metres_per_unit.back() * 4, 1, 1e-4);
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_EQ(refined.turns.size(), 1U);
  EXPECT_TRUE(refined.turns[0].used) << refined.turns[0].reason;
  EXPECT_EQ(refined.turns[0].last_keyframe, kFirstCorner + 22);
  EXPECT_NEAR(refined.path.metres_per_unit.back() * 4, 1, 1e-4);
}

TEST(DriveScale, NothingIsReadAcrossAGap) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), 1);
  while (live.map.keyframes.size() < kFirstCorner + 12) live.Next();
  EXPECT_EQ(live.scale.state(), ScaleState::kObserved);
  live.Next(2.5);
  EXPECT_NE(live.scale.state(), ScaleState::kPending) << "metres stay metres";
  EXPECT_GT(live.scale.sigma(), 0.3) << "30 % more";
  while (live.map.keyframes.size() < kFirstCorner + 15) live.Next();
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_EQ(refined.turns.size(), 1U) << "no turn goes on across a gap";
  EXPECT_TRUE(refined.turns[0].used) << refined.turns[0].reason;
  EXPECT_EQ(refined.turns[0].last_keyframe, kFirstCorner + 11);
  EXPECT_TRUE(refined.keyframes[kFirstCorner + 11].turning);
  EXPECT_FALSE(refined.keyframes[kFirstCorner + 12].turning);
  EXPECT_EQ(refined.keyframes[kFirstCorner + 12].state, ScaleState::kHeld);
  EXPECT_GE(refined.keyframes.back().sigma, 0.3) << "the gap came after the turn";
}

// A map that starts again has two keyframes at once.
TEST(DriveScale, ATurnThatAGapEndsIsNotObservedBehindIt) {
  for (const int more : {0, 1}) {
    Live live(KnownCar(), TrueDrive(kTwoCorners), 1);
    while (live.map.keyframes.size() < kFirstCorner + 12) live.Next();
    ASSERT_EQ(live.scale.state(), ScaleState::kObserved);
    live.Append(2.5);
    if (more == 1) live.Append();
    live.scale.Add(live.map);
    EXPECT_EQ(live.scale.state(), ScaleState::kHeld) << more;
  }
}

TEST(DriveScale, ATurnThatIsNotUsedIsNotObserved) {
  OdometryOptions options = KnownCar();
  options.vehicle.lever_arm.reset();
  options.vehicle.camera_height = 1.5;
  Live live(options, TrueDrive(kTwoCorners), 1, 0.001);
  bool metric = false;
  while (live.map.keyframes.size() < live.truth.size()) {
    live.Append();
    const int k = CountKeyframes(live.map) - 1;
    if (k > 0) {
      MeasuredHeight height;
      height.keyframe = k;
      height.reference = k - 1;
      height.reference_from_keyframe =
          live.map.keyframes[k - 1].camera_from_world * live.map.keyframes[k].camera_from_world.inverse();
      height.ratio = 1.5 / live.TrueStep(k);
      height.sigma = 0.01;
      live.scale.AddHeight(height);
    }
    live.scale.Add(live.map);
    EXPECT_NE(live.scale.state(), ScaleState::kObserved) << k;
    metric = metric || live.scale.state() == ScaleState::kFromRoad;
  }
  EXPECT_TRUE(metric);
  EXPECT_EQ(live.scale.last_turn_end(), 0);
}

TEST(DriveScale, BothSidesOfAGapHaveTheirOwnScale) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), kUnits, 0.001);
  const int gap = kSecondCorner - 8;
  while (CountKeyframes(live.map) < gap) live.Next();
  EXPECT_EQ(live.scale.state(), ScaleState::kHeld);
  live.Next(1.6);
  live.Drive();
  const RefinedScale refined = live.scale.Refine(live.map);
  ASSERT_EQ(refined.turns.size(), 2U);
  for (const TurnResult& turn : refined.turns) EXPECT_TRUE(turn.used) << turn.reason;
  for (int k = 1; k < CountKeyframes(live.map); ++k) {
    if (k == gap) continue;
    EXPECT_NEAR(StepOf(refined.path, k) / live.TrueStep(k), 1, 0.015) << k;
  }
  EXPECT_NEAR(live.scale.live_path().metres_per_unit.back() * kUnits * 1.6, 1, 0.015);
}

TEST(DriveScale, SigmaGrowsWhereLandmarksHardlyDetermineTheUnit) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), kUnits, 0.001);
  live.Drive();
  const int broken = kFirstCorner + 26;
  const double usual = live.scale.Refine(live.map).keyframes[broken + 3].sigma;
  EXPECT_LT(usual, 0.08);
  live.map.keyframes[broken].pixel_unit_variance = std::numeric_limits<double>::infinity();
  const RefinedScale parted = live.scale.Refine(live.map);
  EXPECT_EQ(parted.keyframes[broken - 8].sigma, parted.keyframes[broken - 9].sigma)
      << "only its own turn tells the part before";
  EXPECT_GT(parted.keyframes[broken + 3].sigma, usual) << "the turn before tells nothing of the part after";
  for (const KeyframeScale& scale : parted.keyframes) EXPECT_LT(scale.sigma, 1) << "finite";
  for (Keyframe& keyframe : live.map.keyframes) keyframe.pixel_unit_variance = 1e-4;
  const double weak = live.scale.Refine(live.map).keyframes[broken + 3].sigma;
  EXPECT_GT(weak, 1.1 * usual);
  EXPECT_LT(weak, 0.5);
}

TEST(DriveScale, MarksTheKeyframesOfTurns) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), 1);
  live.Drive();
  const RefinedScale refined = live.scale.Refine(live.map);
  for (const TurnResult& turn : refined.turns) {
    for (int k = turn.first_keyframe; k <= turn.last_keyframe; ++k) {
      EXPECT_EQ(refined.keyframes[k].state, ScaleState::kObserved);
      EXPECT_EQ(refined.keyframes[k].turning, k > turn.first_keyframe) << "the step into a turn is straight";
    }
  }
  EXPECT_EQ(std::ranges::count_if(refined.keyframes, &KeyframeScale::turning), 44 + 1)
      << "one step leads half-way from the street into the second corner";
  for (int k = kFirstCorner + 22; k <= kSecondCorner; ++k)
    EXPECT_GE(refined.keyframes[k].sigma, 0.99 * refined.keyframes[kSecondCorner + 11].sigma)
        << "what turns share stays";
}

TEST(DriveScale, AKeyframeGoneAstrayIsPassed) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), kUnits);
  live.Drive();
  // On the straight, and in both corners.
  const std::vector<int> astray{5, kFirstCorner + 10, 40, kSecondCorner + 7, kSecondCorner + 8};
  Map map;
  DriveScale scale(KnownCar());
  for (const Keyframe& keyframe : live.map.keyframes) {
    map.keyframes.push_back(keyframe);
    const int k = CountKeyframes(map) - 1;
    if (std::ranges::count(astray, k) > 0) map.keyframes[k].camera_from_world.translation.x() = std::nan("");
    if (scale.Add(map)) scale.Reread(map);
    ASSERT_TRUE(scale.live_path().centres[k].allFinite()) << k;
  }
  EXPECT_NE(scale.state(), ScaleState::kPending);
  EXPECT_NEAR(scale.live_path().metres_per_unit.back() * kUnits, 1, 0.02);
  EXPECT_LT(scale.sigma(), 0.1);
  const auto length = [](const DriveScale& drive) {
    return (drive.live_path().centres.back() - drive.live_path().centres.front()).norm();
  };
  EXPECT_NEAR(length(scale) / length(live.scale), 1, 0.02);

  const RefinedScale whole = live.scale.Refine(live.map);
  const RefinedScale refined = scale.Refine(map);
  ASSERT_TRUE(refined.estimate) << refined.reason;
  EXPECT_EQ(refined.turns.size(), whole.turns.size());
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    ASSERT_TRUE(refined.path.centres[k].allFinite()) << k;
    EXPECT_NEAR(refined.path.metres_per_unit[k] / whole.path.metres_per_unit[k], 1, 0.02) << k;
    EXPECT_LT(refined.keyframes[k].sigma, 0.1) << k;
    if (std::ranges::count(astray, static_cast<int>(k)) > 0) continue;
    EXPECT_NEAR((refined.path.centres[k] - whole.path.centres[k]).norm(), 0, 0.02 * length(live.scale)) << k;
  }
}

TEST(StepMotion, IsThatOfTheCar) {
  Live live(KnownCar(), TrueDrive(kTwoCorners), kUnits);
  live.Drive();
  const TurningMotion straight = StepMotion(live.map, 3, live.scale.mount());
  EXPECT_NEAR(straight.psi, 0, 1e-9);
  EXPECT_NEAR(straight.theta, 0, 1e-9);
  EXPECT_NEAR(straight.step, 0.8 * kUnits, 1e-9);
  const TurningMotion left = StepMotion(live.map, kSecondCorner + 5, live.scale.mount());
  EXPECT_NEAR(left.psi, -kCornerStep, 1e-9);
  EXPECT_LT(left.theta, -0.5 * kCornerStep) << "the camera swings outwards";
}

}  // namespace
}  // namespace turnscale
