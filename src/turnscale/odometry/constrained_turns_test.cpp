// SPDX-License-Identifier: MIT
#include "turnscale/odometry/constrained_turns.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/odometry/drive_scale.h"
#include "turnscale/odometry/drive_steps.h"
#include "turnscale/odometry/test_corners.h"

namespace turnscale {
namespace {

OdometryOptions Holding(ScaleMethod method) {
  OdometryOptions options = KnownCar();
  options.scale.method = method;
  return options;
}

/// A finished map in a unit of its own, which drifts, and its truth.
struct FinishedMap {
  Map truth;
  Map map;
};

FinishedMap DriftingMap(const OdometryOptions& options, const std::vector<DriveSegment>& segments, double pixel_noise,
                        double drift = 0.001) {
  const LeverArm lever_arm{kLeverArm, options.vehicle.side_slip};
  FinishedMap finished;
  finished.truth =
      MakeMap(MakeCarDrive(segments, 0.1, lever_arm, kMounting), {.points_per_step = 25, .pixel_noise = pixel_noise});
  finished.map = finished.truth;
  std::vector<double> units;
  for (std::size_t k = 0; k < finished.map.keyframes.size(); ++k)
    units.push_back(0.3 * std::exp(drift * static_cast<double>(k)));
  ScaleMap(units, finished.map);
  return finished;
}

RefinedScale RefinedOf(const OdometryOptions& options, const Map& map) {
  DriveScale scale(options);
  scale.Add(map);
  return scale.Refine(map);
}

double StepOf(const Map& map, int k) { return (Centre(map.keyframes[k]) - Centre(map.keyframes[k - 1])).norm(); }

TEST(ConstrainedTurns, BringTheMapToMetres) {
  const OdometryOptions options = Holding(ScaleMethod::kTurns);
  FinishedMap finished = DriftingMap(options, kTwoCorners, 0.2);
  const Map before = finished.map;
  RefinedScale refined = RefinedOf(options, finished.map);
  const std::vector<double> factors = ConstrainTurns(options, MountCalibration(options.vehicle), finished.map, refined);
  const int count = CountKeyframes(finished.map);
  ASSERT_EQ(factors.size(), finished.map.keyframes.size());
  EXPECT_TRUE(refined.constrained);
  for (int k = 1; k < count; ++k) {
    EXPECT_NEAR(StepOf(finished.map, k) / StepOf(finished.truth, k), 1, 0.05) << k;
    EXPECT_NEAR(factors[k] * StepOf(before, k) / StepOf(finished.truth, k), 1, 0.022) << k;
    EXPECT_EQ(refined.path.centres[k], Centre(finished.map.keyframes[k])) << "the map itself is metric now";
    EXPECT_EQ(refined.path.metres_per_unit[k], 1);
  }
  ASSERT_EQ(refined.turns.size(), 2U);
  for (const TurnResult& turn : refined.turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_EQ(turn.reason, "");
    EXPECT_EQ(turn.unadjusted, "");
    double length = 0;
    double shown = 0;
    for (int k = turn.first_keyframe + 1; k <= turn.last_keyframe; ++k) {
      length += StepOf(finished.map, k);
      shown += turn.as_given * StepOf(before, k);
    }
    EXPECT_NEAR(length / shown, 1, 1e-6) << "held at what the turn says with the car as it was given";
  }
}

TEST(ConstrainedTurns, PaperHoldsEachStepAtItsOwnLength) {
  const OdometryOptions options = Holding(ScaleMethod::kPaper);
  FinishedMap finished = DriftingMap(options, kTwoCorners, 0.02);
  RefinedScale refined = RefinedOf(options, finished.map);
  ConstrainTurns(options, MountCalibration(options.vehicle), finished.map, refined);
  ASSERT_EQ(refined.turns.size(), 2U);
  for (const TurnResult& turn : refined.turns) EXPECT_TRUE(turn.used) << turn.reason;
  for (int k = 1; k < CountKeyframes(finished.map); ++k)
    EXPECT_NEAR(StepOf(finished.map, k) / StepOf(finished.truth, k), 1, 3e-4) << k;
}

TEST(ConstrainedTurns, PaperGivesTheDistancesOfTheObserver) {
  const OdometryOptions options = Holding(ScaleMethod::kPaper);
  const FinishedMap finished = DriftingMap(options, kTwoCorners, 0, 0);
  RefinedScale refined = RefinedOf(options, finished.map);
  const std::vector<TurnScale> held =
      TurnsToConstrain(finished.map, MountCalibration(options.vehicle), options, refined.turns);
  ASSERT_EQ(held.size(), 2U);
  for (const TurnScale& turn : held) {
    EXPECT_NEAR(turn.factor * 0.3, 1, 1e-6);
    EXPECT_EQ(turn.sigma, 0) << "held, not weighed";
    ASSERT_EQ(static_cast<int>(turn.distances.size()), turn.last_step - turn.first_step + 1);
    for (int j = turn.first_step; j <= turn.last_step; ++j) {
      const double distance = turn.distances[j - turn.first_step];
      if (StepOf(finished.truth, j) > 0.7) {
        EXPECT_EQ(distance, 0) << "a straight step of the turn's region tells nothing";
      } else {
        EXPECT_NEAR(distance, 0.6, 1e-6);
      }
    }
  }
}

TEST(ConstrainedTurns, PaperLeavesOutAStepThatContradictsItsTurn) {
  const OdometryOptions options = Holding(ScaleMethod::kPaper);
  FinishedMap finished = DriftingMap(options, kTwoCorners, 0, 0);
  RefinedScale refined = RefinedOf(options, finished.map);
  // The camera of one keyframe goes sideways, so that its step seems to swing out by a third only.
  const int keyframe = (refined.turns[0].first_keyframe + refined.turns[0].last_keyframe) / 2;
  RigidTransform& pose = finished.map.keyframes[keyframe].camera_from_world;
  const MountCalibration mount(options.vehicle);
  const TurningMotion motion = StepMotion(finished.map, keyframe - 1, mount);
  const double swing = motion.step * std::sin(motion.theta - 0.5 * motion.psi);
  const Eigen::Vector3d right = mount.At(keyframe).conjugate() * Eigen::Vector3d::UnitX();
  pose.translation += 2.0 / 3 * swing * right;
  const std::vector<TurnScale> held = TurnsToConstrain(finished.map, mount, options, refined.turns);
  ASSERT_EQ(held.size(), 2U);
  EXPECT_EQ(held[0].distances[keyframe - held[0].first_step], 0);
  EXPECT_GT(held[0].distances[keyframe + 3 - held[0].first_step], 0);
}

TEST(ConstrainedTurns, PaperLeavesOutStepsFarFromTheMedianHoweverTheyScatter) {
  const OdometryOptions options = Holding(ScaleMethod::kPaper);
  FinishedMap finished = DriftingMap(options, kTwoCorners, 0, 0);
  RefinedScale refined = RefinedOf(options, finished.map);
  const MountCalibration mount(options.vehicle);
  // Every third camera of the first turn goes sideways: its two steps seem to swing out by 0.1 and 1.9 of what they
  // do.
  for (int k = refined.turns[0].first_keyframe + 1; k < refined.turns[0].last_keyframe; k += 3) {
    const TurningMotion motion = StepMotion(finished.map, k - 1, mount);
    const double swing = motion.step * std::sin(motion.theta - 0.5 * motion.psi);
    finished.map.keyframes[k].camera_from_world.translation +=
        0.9 * swing * (mount.At(k).conjugate() * Eigen::Vector3d::UnitX());
  }
  const std::vector<TurnScale> held = TurnsToConstrain(finished.map, mount, options, refined.turns);
  ASSERT_EQ(held.size(), 2U);
  int left_out = 0;
  for (std::size_t i = 0; i < held[0].distances.size(); ++i) {
    const double distance = held[0].distances[i];
    const double by_median = held[0].factor * StepOf(finished.map, held[0].first_step + static_cast<int>(i));
    if (distance == 0) {
      ++left_out;
    } else {
      EXPECT_GE(by_median / distance, 0.5 - 1e-9) << i;
      EXPECT_LE(by_median / distance, 1.5 + 1e-9) << i;
    }
  }
  EXPECT_GE(left_out, 3);
}

TEST(ConstrainedTurns, AWeakTurnDoesNotSpoilAGoodOne) {
  OdometryOptions options = Holding(ScaleMethod::kTurns);
  options.vehicle.side_slip = 0;
  const FinishedMap finished =
      DriftingMap(options, {{12, 0.8, 0}, {22, 0.6, kCornerStep}, {15, 1.2, 0}, {6, 1.5, 0.05}, {10, 1.2, 0}}, 0);
  RefinedScale refined = RefinedOf(options, finished.map);
  ASSERT_EQ(refined.turns.size(), 2U);
  EXPECT_TRUE(refined.turns[0].used && refined.turns[1].used);
  const std::vector<TurnScale> held =
      TurnsToConstrain(finished.map, MountCalibration(options.vehicle), options, refined.turns);
  EXPECT_EQ(held.size(), 1U);
  EXPECT_TRUE(refined.turns[0].used) << refined.turns[0].reason;
  EXPECT_FALSE(refined.turns[1].used);
  EXPECT_NE(refined.turns[1].reason, "");
  EXPECT_GT(refined.turns[1].own, 0) << "what it would have said stands in the list";
}

TEST(ConstrainedTurns, AUsedTurnWhoseAdjustmentIsNotBelievedSaysSo) {
  OdometryOptions options = Holding(ScaleMethod::kTurns);
  options.scale.recovery.max_stretch = 1 + 1e-12;
  FinishedMap finished = DriftingMap(options, kTwoCorners, 0.2);
  RefinedScale refined = RefinedOf(options, finished.map);
  ConstrainTurns(options, MountCalibration(options.vehicle), finished.map, refined);
  ASSERT_EQ(refined.turns.size(), 2U);
  for (const TurnResult& turn : refined.turns) {
    EXPECT_TRUE(turn.used);
    EXPECT_EQ(turn.reason, "");
    EXPECT_EQ(turn.unadjusted, "the adjustment changed the path length too much");
  }
}

TEST(ConstrainedTurns, WithoutATurnTheMapStaysAsItIs) {
  const OdometryOptions options = Holding(ScaleMethod::kTurns);
  FinishedMap finished = DriftingMap(options, {{60, 0.8, 0}}, 0.2);
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(finished.map);
  RefinedScale refined = RefinedOf(options, finished.map);
  EXPECT_TRUE(ConstrainTurns(options, MountCalibration(options.vehicle), finished.map, refined).empty());
  EXPECT_EQ(KeyframeCentres(finished.map), before);
  EXPECT_FALSE(refined.constrained);
}

TEST(ConstrainedTurns, APathOfOtherLengthsDiffersFromTheInterpolatedOne) {
  // The first half has this length, in place of 10 m; the second one has 10 m.
  const auto path = [](double first_half) {
    RefinedScale refined;
    refined.estimate.emplace().length_sigma = 0.05;
    for (int k = 0; k <= 20; ++k)
      refined.path.centres.emplace_back(0, 0, std::min(0.1 * k, 1.0) * first_half + std::max(0, k - 10));
    return refined;
  };
  Map map;
  map.keyframes.resize(21);
  EXPECT_EQ(DifferenceFromInterpolated(map, path(10), path(10)), 0);
  EXPECT_EQ(DifferenceFromInterpolated(map, path(11.8), path(10)), 0) << "9 %";
  EXPECT_NEAR(DifferenceFromInterpolated(map, path(14), path(10)), 0.2, 1e-9);
  EXPECT_NEAR(DifferenceFromInterpolated(map, path(6), path(10)), 0.2, 1e-9);
  for (int k = 1; k <= 10; ++k) map.keyframes[k].after_gap = true;
  EXPECT_EQ(DifferenceFromInterpolated(map, path(14), path(10)), 0) << "no step is measured";
}

TEST(ConstrainedTurns, AMapWithAPoseThatIsNotFiniteStaysAsItIs) {
  const OdometryOptions options = Holding(ScaleMethod::kTurns);
  FinishedMap finished = DriftingMap(options, kTwoCorners, 0.2);
  finished.map.keyframes[5].camera_from_world.translation.x() = std::nan("");
  RefinedScale refined = RefinedOf(options, finished.map);
  ASSERT_TRUE(refined.estimate) << refined.reason;
  EXPECT_TRUE(ConstrainTurns(options, MountCalibration(options.vehicle), finished.map, refined).empty());
  EXPECT_FALSE(refined.constrained);
  for (const TurnResult& turn : refined.turns) EXPECT_EQ(turn.unadjusted.empty(), !turn.used);
  for (const Eigen::Vector3d& centre : refined.path.centres) EXPECT_TRUE(centre.allFinite());
}

TEST(ConstrainedTurns, WhereAllTurnsAreLeftOutThePathStays) {
  const OdometryOptions options = Holding(ScaleMethod::kTurns);
  FinishedMap finished = DriftingMap(options, kTwoCorners, 0.2);
  RefinedScale refined = RefinedOf(options, finished.map);
  for (TurnResult& turn : refined.turns) turn.used_singly = false;
  const MetricPath before = refined.path;
  EXPECT_TRUE(ConstrainTurns(options, MountCalibration(options.vehicle), finished.map, refined).empty());
  EXPECT_FALSE(refined.constrained);
  EXPECT_EQ(refined.path.centres, before.centres);
  for (const TurnResult& turn : refined.turns) EXPECT_NE(turn.reason, "");
}

}  // namespace
}  // namespace turnscale
