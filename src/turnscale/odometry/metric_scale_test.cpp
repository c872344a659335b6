// SPDX-License-Identifier: MIT
#include "turnscale/odometry/metric_scale.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/scale/map_scaling.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kMounting = RotationFromYawPitchRoll({0.03, -0.05, 0.01});
constexpr double kLeverArm = 1.2;
constexpr double kQuarter = M_PI / 2 / 22;

// Two corners of 90 degrees with a street between.
const std::vector<DriveSegment> kTwoCorners = {
    {12, 0.8, 0}, {22, 0.6, kQuarter}, {25, 0.8, 0}, {22, 0.6, -kQuarter}, {12, 0.8, 0}};
constexpr int kFirstCorner = 12;   // the keyframe where it begins
constexpr int kSecondCorner = 59;  // likewise

OdometryOptions Options() {
  OdometryOptions options;
  options.vehicle.lever_arm = kLeverArm;
  options.vehicle.vehicle_from_camera = kMounting;
  options.vehicle.calibrate_camera = false;
  return options;
}

Map TrueMap(const OdometryOptions& options, const std::vector<DriveSegment>& segments, double noise = 0.2) {
  const LeverArm lever_arm{kLeverArm, options.vehicle.side_slip};
  return MakeMap(MakeCarDrive(segments, 0.1, lever_arm, kMounting), {.points_per_step = 25, .pixel_noise = noise});
}

// A drive as the odometry lives it: keyframe by keyframe, in a unit of its own until a turn gives metres.
struct Live {
  Map truth;
  double units_per_metre = 1;
  Map map;
  MetricScale scale;

  Live(const OdometryOptions& options, const std::vector<DriveSegment>& segments, double unit, double noise = 0.2)
      : truth(TrueMap(options, segments, noise)), units_per_metre(unit), scale(options) {
    map.pinhole = truth.pinhole;
    map.landmarks.resize(truth.landmarks.size());
  }

  ScaleUpdate Next(bool after_gap = false) {
    const int k = static_cast<int>(map.keyframes.size());
    RigidTransform pose = truth.keyframes[k].camera_from_world;
    if (k > 0) {
      RigidTransform step = pose * truth.keyframes[k - 1].camera_from_world.inverse();
      step.translation *= units_per_metre;
      pose = step * map.keyframes.back().camera_from_world;
    }
    map.keyframes.push_back({k, truth.keyframes[k].time, pose, {}, after_gap});
    for (const KeyframeObservation& seen : truth.keyframes[k].observations) {
      AddObservation(map, k, seen.landmark, seen.pixel);
      Landmark& landmark = map.landmarks[seen.landmark];
      if (landmark.valid || landmark.observations.size() < 2) continue;
      const Eigen::Vector3d x = truth.keyframes[k].camera_from_world * truth.landmarks[seen.landmark].position;
      landmark.position = pose.inverse() * (units_per_metre * x).eval();
      landmark.valid = true;
    }
    return Followed(scale.AddKeyframe(k, map));
  }

  ScaleUpdate Followed(ScaleUpdate update) {
    if (!update.factors.empty()) {
      EXPECT_EQ(update.factors.size(), map.keyframes.size());
      units_per_metre *= update.factors.back();
    }
    return update;
  }

  void Drive() {
    while (map.keyframes.size() < truth.keyframes.size()) Next();
    Followed(scale.Finish(map));
  }

  double Step(int k) const { return StepOf(map, k); }
  double TrueStep(int k) const { return StepOf(truth, k); }

  static double StepOf(const Map& map, int k) {
    return (map.keyframes[k].camera_from_world * map.keyframes[k - 1].camera_from_world.inverse()).translation.norm();
  }
};

TEST(MetricScale, TwoCornersGiveMetres) {
  const OdometryOptions options = Options();
  Live live(options, kTwoCorners, 0.3);
  while (live.map.keyframes.size() < kFirstCorner + 20) {
    EXPECT_TRUE(live.Next().factors.empty());
    EXPECT_EQ(live.scale.state(), ScaleState::kPending);
    EXPECT_TRUE(std::isinf(live.scale.sigma()));
  }
  live.Drive();
  EXPECT_EQ(live.scale.state(), ScaleState::kHeld);
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 2U);
  for (const TurnResult& turn : turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_EQ(turn.reason, "");
    EXPECT_EQ(turn.unadjusted, "");
    EXPECT_NEAR(turn.metres_per_unit * 0.3, 1, 0.03);
    EXPECT_NEAR(turn.speed, 6, 0.2);
    EXPECT_EQ(turn.keyframes, turn.last_frame - turn.first_frame + 1);
    EXPECT_GT(turn.sigma, 0);
  }
  EXPECT_EQ(turns[0].first_frame, kFirstCorner);
  EXPECT_EQ(turns[0].last_frame, kFirstCorner + 22);
  EXPECT_NEAR(turns[0].angle, M_PI / 2, 0.01);
  EXPECT_NEAR(turns[1].angle, -M_PI / 2, 0.01);
  EXPECT_NEAR(turns[1].first_frame, kSecondCorner, 0);
  for (int k = 1; k < static_cast<int>(live.map.keyframes.size()); ++k)
    EXPECT_NEAR(live.Step(k) / live.TrueStep(k), 1, 0.05) << k;
  EXPECT_LT(live.scale.sigma(), 0.05);
}

TEST(MetricScale, TheArbitraryUnitDoesNotMatter) {
  const OdometryOptions options = Options();
  Live one(options, kTwoCorners, 1);
  one.Drive();
  for (const double unit : {0.1, 10.0}) {
    Live other(options, kTwoCorners, unit);
    other.Drive();
    for (int k = 1; k < static_cast<int>(one.map.keyframes.size()); ++k)
      EXPECT_NEAR(other.Step(k) / one.Step(k), 1, 1e-6) << unit << ' ' << k;
    for (const int turn : {0, 1})
      EXPECT_NEAR(
          other.scale.Turns(other.map)[turn].metres_per_unit * unit / one.scale.Turns(one.map)[turn].metres_per_unit, 1,
          1e-6);
    EXPECT_NEAR(other.scale.sigma() / one.scale.sigma(), 1, 1e-5);
  }
}

TEST(MetricScale, FindsTheMountAndReadsTheTurnsBeforeAgain) {
  OdometryOptions options = Options();
  options.vehicle.vehicle_from_camera = Eigen::Quaterniond::Identity();
  Live assumed(options, kTwoCorners, 0.3);
  assumed.Drive();
  EXPECT_GT(std::abs(assumed.scale.Turns(assumed.map)[0].metres_per_unit * 0.3 - 1), 0.1) << "1.7 deg of yaw matter";

  options.vehicle.calibrate_camera = true;
  Live live(options, kTwoCorners, 0.3);
  live.Drive();
  EXPECT_LT(live.scale.mount().current().vehicle_from_camera.angularDistance(kMounting), 0.3 / kDegreesPerRadian);
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 2U);
  for (const TurnResult& turn : turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_NEAR(turn.metres_per_unit * 0.3, 1, 0.04);
  }
  for (int k = 1; k < static_cast<int>(live.map.keyframes.size()); ++k)
    EXPECT_NEAR(live.Step(k) / live.TrueStep(k), 1, 0.06) << k;
}

TEST(MetricScale, ATurnThatOnlyTheMountExplainsIsUsedOnceItIsKnown) {
  OdometryOptions options = Options();
  // So far off that no turn to one side can be read.
  options.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.03 + 0.3, -0.05, 0.01});
  Live assumed(options, kTwoCorners, 1);
  assumed.Drive();
  const std::vector<TurnResult> unread = assumed.scale.Turns(assumed.map);
  EXPECT_TRUE(!unread[0].used || !unread[1].used);

  options.vehicle.calibrate_camera = true;
  Live live(options, kTwoCorners, 1);
  live.Drive();
  EXPECT_EQ(live.scale.state(), ScaleState::kHeld);
  for (const TurnResult& turn : live.scale.Turns(live.map)) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_EQ(turn.reason, "");
    EXPECT_NEAR(turn.metres_per_unit, 1, 0.04);
  }
}

// Root mean square of how far the lengths of turning steps are off, in log-scale.
double ErrorOfTurns(const OdometryOptions& options, const std::vector<DriveSegment>& segments) {
  Live live(options, segments, 0.3, 1.0);
  live.Drive();
  double squares = 0;
  int steps = 0;
  for (const TurnResult& turn : live.scale.Turns(live.map)) {
    for (int k = turn.first_frame + 1; k <= turn.last_frame; ++k) {
      const double off = std::log(live.Step(k) / live.TrueStep(k));
      squares += off * off;
      ++steps;
    }
  }
  return std::sqrt(squares / steps);
}

std::vector<DriveSegment> TurnsToBothSides() {
  std::vector<DriveSegment> segments = {{12, 0.8, 0}};
  for (int i = 0; i < 6; ++i) {
    segments.push_back({22, 0.6, i % 2 == 0 ? kQuarter : -kQuarter});
    segments.push_back({15, 0.8, 0});
  }
  return segments;
}

// A yaw that is off makes right and left turns disagree; together they show it.
TEST(MetricScale, TurnsCountWithWhatAllOfThemSay) {
  const std::vector<DriveSegment> segments = TurnsToBothSides();
  OdometryOptions options = Options();
  options.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.03 + 0.005, -0.05, 0.01});
  const double smooth = ErrorOfTurns(options, segments);
  options.scale.smooth = false;
  EXPECT_LT(smooth, 0.6 * ErrorOfTurns(options, segments));
}

TEST(MetricScale, AllTurnsTogetherTellWhatTheYawHasWrong) {
  OdometryOptions options = Options();
  options.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.03 - 0.01, -0.05, 0.01});
  Live live(options, TurnsToBothSides(), 0.3);
  EXPECT_FALSE(live.scale.car());
  live.Drive();
  ASSERT_TRUE(live.scale.car());
  EXPECT_NEAR(live.scale.car()->yaw_error, 0.01, 0.002);
  options.scale.smooth = false;
  Live held(options, TurnsToBothSides(), 0.3);
  held.Drive();
  EXPECT_FALSE(held.scale.car());
}

TEST(MetricScale, PerFrameMethodGivesMetresToo) {
  OdometryOptions options = Options();
  options.pooled_scale.method = ScaleMethod::kPerFrame;
  options.scale.smooth = false;
  Live live(options, kTwoCorners, 0.3, 0.02);
  live.Drive();
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 2U);
  for (const TurnResult& turn : turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_NEAR(turn.metres_per_unit * 0.3, 1, 0.02);
  }
  for (int k = 1; k < static_cast<int>(live.map.keyframes.size()); ++k)
    EXPECT_NEAR(live.Step(k) / live.TrueStep(k), 1, 0.08) << k;
}

TEST(MetricScale, StaysPendingWithoutALeverArm) {
  OdometryOptions options = Options();
  options.vehicle.lever_arm.reset();
  Live live(options, kTwoCorners, 0.3);
  live.Drive();
  EXPECT_EQ(live.scale.state(), ScaleState::kPending);
  EXPECT_TRUE(std::isinf(live.scale.sigma()));
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 2U);
  for (const TurnResult& turn : turns) {
    EXPECT_FALSE(turn.used);
    EXPECT_EQ(turn.reason, "no lever arm given");
    EXPECT_EQ(turn.metres_per_unit, 0);
    EXPECT_NEAR(std::abs(turn.angle), M_PI / 2, 0.01) << "the turn itself is seen";
  }
  EXPECT_NEAR(live.units_per_metre, 0.3, 1e-3) << "adjusted, not brought to metres";
}

TEST(MetricScale, ATurnThatTellsNothingSaysWhy) {
  OdometryOptions options = Options();
  options.vehicle.side_slip = 0;
  options.pooled_scale.max_relative_sigma = 0.05;
  Live live(options, {{10, 1.5, 0}, {6, 2.5, 0.06}, {10, 1.5, 0}}, 1);
  live.Drive();
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 1U);
  EXPECT_FALSE(turns[0].used);
  EXPECT_NE(turns[0].reason, "");
  EXPECT_EQ(live.scale.state(), ScaleState::kPending);
}

TEST(MetricScale, AWeakTurnDoesNotSpoilAGoodOne) {
  OdometryOptions options = Options();
  options.scale.smooth = false;
  options.vehicle.side_slip = 0;
  Live live(options, {{10, 0.8, 0}, {22, 0.6, kQuarter}, {15, 1.2, 0}, {6, 1.5, 0.05}, {10, 1.2, 0}}, 1);
  live.Drive();
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 2U);
  EXPECT_TRUE(turns[0].used) << turns[0].reason;
  EXPECT_FALSE(turns[1].used);
  EXPECT_EQ(turns[1].reason, "its scale is less certain than the one carried here");
  EXPECT_GT(turns[1].metres_per_unit, 0) << "what it would have said stands in the list";
  EXPECT_EQ(live.scale.state(), ScaleState::kHeld);
}

TEST(MetricScale, AUsedTurnWhoseAdjustmentIsNotBelievedSaysSo) {
  OdometryOptions options = Options();
  options.scale.recovery.max_stretch = 1 + 1e-12;
  Live live(options, kTwoCorners, 0.3);
  live.Drive();
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 2U);
  for (const TurnResult& turn : turns) {
    EXPECT_TRUE(turn.used);
    EXPECT_EQ(turn.reason, "");
    EXPECT_EQ(turn.unadjusted, "the adjustment changed the length of the path too much");
  }
}

TEST(MetricScale, ATurnThatIsStillOpenClosesAtTheEnd) {
  Live live(Options(), {{12, 0.8, 0}, {22, 0.6, kQuarter}}, 4);
  while (live.map.keyframes.size() < live.truth.keyframes.size()) live.Next();
  EXPECT_EQ(live.scale.state(), ScaleState::kPending);
  const ScaleUpdate update = live.Followed(live.scale.Finish(live.map));
  EXPECT_EQ(live.scale.state(), ScaleState::kObserved);
  ASSERT_EQ(update.factors.size(), live.map.keyframes.size());
  EXPECT_NEAR(update.factors.back() * 4, 1, 0.05);
}

TEST(MetricScale, MetresPerFirstUnitKnowOfAnAdjustmentBeforeAGap) {
  constexpr double kUnit = 0.3;
  Live live(Options(), kTwoCorners, kUnit);
  while (live.map.keyframes.size() < kFirstCorner) live.Next();
  // The live map has gone wrong: its last steps are too long.
  const std::vector<Eigen::Vector3d> centres = KeyframeCentres(live.map);
  std::vector<Eigen::Vector3d> stretched = centres;
  for (size_t k = kFirstCorner - 4; k < centres.size(); ++k)
    stretched[k] = stretched[k - 1] + 1.3 * (centres[k] - centres[k - 1]);
  SetKeyframeCentres(stretched, live.map);
  live.units_per_metre *= 1.3;
  const double adjustment = live.Followed(live.scale.Finish(live.map)).factors.back();
  EXPECT_LT(adjustment, 0.9);
  live.Next(true);
  while (live.scale.state() == ScaleState::kPending) {
    ASSERT_LT(live.map.keyframes.size(), live.truth.keyframes.size());
    const double units_per_metre = live.units_per_metre;
    live.Next();
    if (live.scale.state() == ScaleState::kPending) continue;
    const std::vector<TurnResult> turns = live.scale.Turns(live.map);
    ASSERT_EQ(turns.size(), 1U);
    EXPECT_NEAR(turns[0].metres_per_unit * units_per_metre / adjustment, 1, 0.04);
  }
}

TEST(MetricScale, ABridgedStepIsNoMotion) {
  Live live(Options(), kTwoCorners, 1);
  while (live.map.keyframes.size() < kFirstCorner + 10) {
    const ScaleUpdate update = live.Next();
    EXPECT_NEAR(update.motion.psi, live.map.keyframes.size() > kFirstCorner + 1 ? kQuarter : 0, 1e-3);
  }
  const ScaleUpdate update = live.Next(true);
  EXPECT_EQ(update.motion.psi, 0);
  EXPECT_EQ(update.motion.step, 0);
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 1U) << "no turn goes on across a gap";
  EXPECT_TRUE(turns[0].used) << turns[0].reason;
  EXPECT_GE(live.scale.sigma(), Options().scale.gap_sigma) << "the gap came after the turn";
  EXPECT_EQ(turns[0].last_frame, kFirstCorner + 9);
}

TEST(MetricScale, APathThatEndsInTheMiddleLeavesItsScaleToTheRest) {
  Live live(Options(), kTwoCorners, 0.3);
  while (live.map.keyframes.size() < kSecondCorner - 8) live.Next();
  EXPECT_EQ(live.scale.state(), ScaleState::kHeld);
  live.Followed(live.scale.EndPath(live.map));
  live.Next(true);
  live.Drive();
  const std::vector<TurnResult> turns = live.scale.Turns(live.map);
  ASSERT_EQ(turns.size(), 2U);
  for (const TurnResult& turn : turns) EXPECT_TRUE(turn.used) << turn.reason;
  for (int k = 1; k < static_cast<int>(live.map.keyframes.size()); ++k) {
    if (live.map.keyframes[k].after_gap) continue;
    EXPECT_NEAR(live.Step(k) / live.TrueStep(k), 1, 0.05) << k;
  }
}

TEST(MetricScale, AnnotatesFramesFromBothSides) {
  Live live(Options(), kTwoCorners, 1);
  live.Drive();
  const int keyframes = static_cast<int>(live.map.keyframes.size());
  std::vector<FrameResult> frames(keyframes + 1);
  std::vector<int> keyframe_of_frame;
  for (int k = 0; k < keyframes; ++k) {
    frames[k].keyframe = true;
    keyframe_of_frame.push_back(k);
  }
  keyframe_of_frame.push_back(-1);
  live.scale.Annotate(live.map, keyframe_of_frame, frames);

  EXPECT_TRUE(std::isnan(frames[0].psi)) << "no step leads to the first keyframe";
  EXPECT_NEAR(frames[kFirstCorner + 5].psi, kQuarter, 1e-3);
  EXPECT_NEAR(frames[kSecondCorner + 5].psi, -kQuarter, 1e-3);
  EXPECT_GT(frames[kFirstCorner + 5].theta, 0.5 * kQuarter) << "the camera swings outwards";
  for (int k = 0; k < keyframes; ++k) {
    const bool observed =
        (k >= kFirstCorner && k <= kFirstCorner + 22) || (k >= kSecondCorner && k <= kSecondCorner + 22);
    EXPECT_EQ(frames[k].scale_state, observed ? ScaleState::kObserved : ScaleState::kHeld) << k;
    const bool turns = std::abs(frames[k].psi) > 0.5 * kQuarter;
    EXPECT_EQ(frames[k].turning, turns) << k;
    EXPECT_EQ(turns, observed && k != kFirstCorner && k != kSecondCorner) << "the step into a turn is straight";
    EXPECT_TRUE(std::isfinite(frames[k].scale_sigma));
  }
  EXPECT_NEAR(frames[kFirstCorner].scale_sigma, frames[kFirstCorner + 22].scale_sigma, 0.002);
  for (int k = kFirstCorner + 22; k <= kSecondCorner; ++k) {
    EXPECT_GE(frames[k].scale_sigma, 0.99 * frames[kSecondCorner].scale_sigma) << "what turns share stays";
  }
  EXPECT_EQ(frames[keyframes].scale_state, ScaleState::kPending) << "it has no keyframe";
  EXPECT_TRUE(std::isinf(frames[keyframes].scale_sigma));
}

}  // namespace
}  // namespace turnscale
