// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/base/test_seeds.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/synthetic_drive.h"
#include "turnscale/scale/synthetic_steps.h"
#include "turnscale/scale/test_estimates.h"

namespace turnscale {
namespace {

/// As little unknown as can be.
CarPrior Exactly(const LeverArm& car) {
  CarPrior prior = PriorOf(car);
  prior.lever_arm_sigma = 0;
  prior.side_slip_sigma = 0;
  return prior;
}

ScaleEstimate EstimateOf(const SyntheticSteps& drive, const CarPrior& car, const ScaleEstimatorOptions& options = {}) {
  ScaleEstimateResult result = EstimateScale(drive.steps, car, options);
  EXPECT_TRUE(result.estimate) << result.reason;
  return result.estimate.value_or(ScaleEstimate{});
}

/// No lag is ever found: one may explain turns that scatter, or those of a car that does not exist.
ScaleEstimatorOptions FindingNoLag() {
  ScaleEstimatorOptions options;
  options.stabilisation.enabled = false;
  return options;
}

/// The mean of the true log-scales in a segment, against the estimate.
double LogError(const ScaleEstimate& estimate, const SyntheticSteps& drive, std::size_t i) {
  const PathSegment& segment = estimate.segments[i];
  double truth = 0;
  for (int k = segment.first; k <= segment.last; ++k) truth += std::log(drive.metres_per_unit[k]);
  return estimate.smoothed[i].mean[kLogScale] - truth / (segment.last - segment.first + 1);
}

TEST(ScaleEstimator, FindsTheMetreOfAPerfectDrive) {
  const ScaleEstimate estimate = EstimateOf(MakeSteps(TownRoad(6, 1), kCar, 0, kUnit), PriorOf(kCar));
  ASSERT_EQ(estimate.turns.size(), 6u);
  for (const ScaleBelief& belief : estimate.smoothed) EXPECT_NEAR(belief.metres_per_unit() / kUnit, 1, 1e-5);
  EXPECT_NEAR(estimate.car.side_slip, kCar.side_slip, 1e-6);
  EXPECT_NEAR(estimate.car.yaw_error, 0, 1e-6);
  EXPECT_TRUE(estimate.converged);
  EXPECT_FALSE(estimate.uses_single_turns);
  EXPECT_FALSE(estimate.test.contradicted);
  for (const TurnEstimate& turn : estimate.turns) {
    EXPECT_TRUE(turn.used) << turn.reason;
    EXPECT_NEAR(turn.own / kUnit, 1, 1e-5);
    EXPECT_NEAR(turn.as_given / kUnit, 1, 1e-5);
    EXPECT_NEAR(turn.smoothed / kUnit, 1, 1e-5);
    EXPECT_EQ(turn.weight, 1);
    EXPECT_GT(turn.own_relative_sigma, EvidenceOptions().turn_sigma) << "the least that a turn may differ by";
    EXPECT_LT(turn.smoothed_relative_sigma, turn.own_relative_sigma + 0.03);
    EXPECT_NEAR(turn.lever_arm_units * kUnit, kCar.At(turn.speed_units * kUnit), 1e-5);
  }
}

TEST(ScaleEstimator, ReadsACarOnARoadThroughItsCamera) {
  const Eigen::Quaterniond mount = RotationFromYawPitchRoll({0, -0.1, 0});
  std::vector<DriveSegment> route{{60, 0.9, 0}};
  for (int i = 0; i < 6; ++i) {
    const double side = i % 3 == 1 ? -1 : 1;
    route.push_back({i % 2 == 0 ? 45 : 30, i % 2 == 0 ? 0.7 : 0.4, side * M_PI / 2 / (i % 2 == 0 ? 45 : 30)});
    route.push_back({60 + 20 * (i % 4), 0.9, 0});
  }
  Trajectory path;
  for (const RigidTransform& pose : MakeCarDrive(route, 0.1, kCar, mount).world_from_camera) {
    // In vehicle axes whose pitch is not known.
    path.push_back({0.1 * static_cast<double>(path.size()), {pose.rotation, pose.translation / kUnit}});
  }
  const ScaleEstimateResult result = EstimateScale(CutIntoSteps(path, {}, true, {}), PriorOf(kCar), {});
  ASSERT_TRUE(result.estimate) << result.reason;
  EXPECT_EQ(result.estimate->turns.size(), 6u);
  EXPECT_NEAR(Metres(*result.estimate) /
                  (kUnit *
                   [&] {
                     double length = 0;
                     for (std::size_t i = 1; i < path.size(); ++i)
                       length +=
                           (path[i].world_from_camera.translation - path[i - 1].world_from_camera.translation).norm();
                     return length;
                   }()),
              1, 2e-4)
      << "steps across the ends of a turn are no single circle";
}

TEST(ScaleEstimator, FindsSlipAndYawThatWereGivenWrong) {
  int slip_within = 0;
  int yaw_within = 0;
  constexpr int kDrives = 40;
  for (int seed = 0; seed < kDrives; ++seed) {
    CarPrior prior = Exactly({kCar.length, 0.0035});
    prior.side_slip_sigma = 0.002;
    const double yaw = -0.4 * kDegree;
    const ScaleEstimate estimate = EstimateOf(MakeSteps(TownRoad(16, seed), kCar, -yaw, kUnit, kNoise, seed), prior);
    slip_within += std::abs(estimate.car.side_slip - kCar.side_slip) < 2 * estimate.car.side_slip_sigma;
    yaw_within += std::abs(estimate.car.yaw_error - yaw) < 2 * estimate.car.yaw_error_sigma;
    EXPECT_LT(estimate.car.side_slip_sigma, 0.0015);
    EXPECT_LT(estimate.car.yaw_error_sigma, 0.05 * kDegree);
    EXPECT_GT(estimate.car.side_slip, 0.0035);
  }
  EXPECT_GE(slip_within, 0.85 * kDrives);
  EXPECT_GE(yaw_within, 0.85 * kDrives);
}

TEST(ScaleEstimator, ASlipUnlikeAnyTyresIsReportedAndWidensSigma) {
  int usual = 0;
  for (int seed = 0; seed < 20; ++seed) {
    CarPrior prior = Exactly(kCar);
    prior.side_slip = kUsualSideSlip;
    prior.side_slip_sigma = kUsualSideSlipSigma;
    usual += EstimateOf(MakeSteps(TownRoad(16, seed), kCar, 0, kUnit, kNoise, seed), prior).slip_conflict ? 1 : 0;
    // As of a car that drives twice as fast as the times say.
    const SyntheticSteps drive = MakeSteps(TownRoad(16, seed), {kCar.length, 0.018}, 0, kUnit, kNoise, seed);
    const ScaleEstimate estimate = EstimateOf(drive, prior);
    if (estimate.test.contradicted) continue;
    ASSERT_TRUE(estimate.slip_conflict) << seed;
    EXPECT_GT(estimate.slip_conflict->found, kUsualSideSlip + 2.5 * kUsualSideSlipSigma);
    EXPECT_GE(estimate.length_sigma, estimate.test.disagreement);
  }
  EXPECT_LE(usual, 1);
}

TEST(ScaleEstimator, AnyUnitGivesTheSameMetres) {
  DriveErrors errors = kNoise;
  errors.per_100m = 0.01;
  const ScaleEstimate one = EstimateOf(MakeSteps(TownRoad(8, 3), kCar, 0.003, 1, errors, 4), PriorOf(kCar));
  for (const double unit : {0.02, 30.0, 5000.0}) {
    const ScaleEstimate other = EstimateOf(MakeSteps(TownRoad(8, 3), kCar, 0.003, unit, errors, 4), PriorOf(kCar));
    EXPECT_NEAR(Metres(other) / Metres(one), 1, 1e-7);
    EXPECT_NEAR(other.length_sigma / one.length_sigma, 1, 1e-5);
    EXPECT_NEAR(other.car.side_slip, one.car.side_slip, 1e-8);
    EXPECT_NEAR(other.test.chi_squared / one.test.chi_squared, 1, 1e-4);
  }
}

TEST(ScaleEstimator, ADriftIsFollowed) {
  double followed = 0;
  double constant = 0;
  int inside = 0;
  int count = 0;
  for (int seed = 0; seed < 30; ++seed) {
    ScaleEstimatorOptions options;
    options.drift.per_100m = 0.03;
    DriveErrors errors = AsStated(options);
    const SyntheticSteps drive = MakeSteps(TownRoad(14, seed), kCar, 0, kUnit, errors, seed);
    const ScaleEstimate estimate = EstimateOf(drive, Exactly(kCar), options);
    double mean = 0;
    for (const double scale : drive.metres_per_unit) mean += std::log(scale);
    mean /= static_cast<double>(drive.metres_per_unit.size());
    for (std::size_t i = 0; i < estimate.segments.size(); ++i) {
      const double error = LogError(estimate, drive, i);
      followed += error * error;
      constant += std::pow(estimate.smoothed[i].mean[kLogScale] - error - mean, 2);
      inside += std::abs(error) < estimate.smoothed[i].sigma();
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(followed / constant), 0.5);
  EXPECT_GT(inside / static_cast<double>(count), 0.6);
  EXPECT_LT(inside / static_cast<double>(count), 0.85);
}

TEST(ScaleEstimator, TyresDoNotSlipInwards) {
  // A car whose lever arm grows with speed.
  CarPrior prior = Exactly({1.5, 0.002});
  prior.side_slip_sigma = 0.003;
  const ScaleEstimate estimate =
      EstimateOf(MakeSteps(TownRoad(8, 5), {1.5, -0.004}, 0, kUnit, kNoise, 5), prior, FindingNoLag());
  EXPECT_TRUE(estimate.car.side_slip_at_bound);
  EXPECT_GE(estimate.car.side_slip, 0);
  EXPECT_LT(estimate.car.side_slip, 1e-6);
  const ScaleEstimate usual = EstimateOf(MakeSteps(TownRoad(8, 5), kCar, 0, kUnit, kNoise, 5), PriorOf(kCar));
  EXPECT_FALSE(usual.car.side_slip_at_bound);
}

TEST(ScaleEstimator, WhatIsKnownExactlyIsNotRefined) {
  const CarPrior exact = Exactly({1.5, 0.004});
  const ScaleEstimate estimate = EstimateOf(MakeSteps(TownRoad(8, 6), kCar, 0, kUnit, kNoise, 6), exact);
  EXPECT_NEAR(estimate.car.side_slip, 0.004, 1e-9);
  EXPECT_EQ(estimate.car.side_slip_sigma, 0);
  EXPECT_FALSE(estimate.car.side_slip_at_bound);
  for (const ScaleBelief& belief : estimate.smoothed) EXPECT_NEAR(std::exp(belief.mean[kLogLeverArm]), 1.5, 1e-8);
}

TEST(ScaleEstimator, TheLeverArmsOwnSigmaIsInTheLengths) {
  const LeverArm rigid{1.5, 0};
  const SyntheticSteps drive = MakeSteps(TownRoad(12, 7), rigid, 0, kUnit, kNoise, 7);
  CarPrior prior = Exactly(rigid);
  const double without = EstimateOf(drive, prior).length_sigma;
  prior.lever_arm_sigma = 0.15;
  EXPECT_NEAR(EstimateOf(drive, prior).length_sigma, std::hypot(without, 0.1), 0.0003)
      << "a tenth of the lever arm is a tenth of the path";
}

TEST(ScaleEstimator, FastTurnsCarryTheSlipsUncertainty) {
  const auto sigma_at = [](double speed) {
    std::vector<StretchOfRoad> road;
    for (int i = 0; i < 5; ++i) {
      road.push_back({25, 0, 6, 10});
      road.push_back({30, (i % 2 ? 1 : -1) * 3 * kDegree, 0.05 * speed * speed / 2, speed});
    }
    return EstimateOf(MakeSteps(road, kCar, 0, kUnit), PriorOf(kCar)).length_sigma;
  };
  EXPECT_GT(sigma_at(9), 1.5 * sigma_at(4));
}

TEST(ScaleEstimator, TurnsThatAreTooFastAreLeftOut) {
  std::vector<StretchOfRoad> road = TownRoad(5, 8);
  const ScaleEstimate without = EstimateOf(MakeSteps(road, kCar, 0, kUnit), PriorOf(kCar));
  // At 15.5 m/s a fifth of the lever arm is left, and what the tyres really do counts for everything.
  road.push_back({30, 0.06, 2, 15.5});
  road.push_back({20, 0, 6, 12});
  const ScaleEstimate with = EstimateOf(MakeSteps(road, {1.5, 0.005}, 0, kUnit), PriorOf(kCar));
  ASSERT_EQ(with.turns.size(), 6u);
  EXPECT_FALSE(with.turns.back().used);
  EXPECT_NE(with.turns.back().reason.find("too fast"), std::string::npos) << with.turns.back().reason;
  EXPECT_EQ(with.turns.back().own, 0);
  EXPECT_GT(with.turns.back().smoothed, 0) << "the others say what scale it has";
  EXPECT_NEAR(with.smoothed.front().metres_per_unit(), without.smoothed.front().metres_per_unit(), 1e-4 * kUnit);
}

TEST(ScaleEstimator, SaysWhyThereIsNoScale) {
  const ScaleEstimateResult straight =
      EstimateScale(MakeSteps({{100, 0, 6, 10}}, kCar, 0, kUnit, kNoise).steps, PriorOf(kCar), {});
  EXPECT_FALSE(straight.estimate);
  EXPECT_NE(straight.reason.find("no turn"), std::string::npos) << straight.reason;
  EXPECT_NE(straight.reason.find("15 degrees"), std::string::npos) << "says what would do";
  EXPECT_TRUE(straight.detected_turns.empty());
  EXPECT_FALSE(EstimateScale({}, PriorOf(kCar), {}).estimate);

  const ScaleEstimateResult fast = EstimateScale(
      MakeSteps({{30, 0, 6, 16}, {30, 0.06, 2, 16}, {30, 0, 6, 16}}, kCar, 0, kUnit).steps, PriorOf(kCar), {});
  EXPECT_FALSE(fast.estimate);
  EXPECT_NE(fast.reason.find("slow"), std::string::npos) << fast.reason;
  ASSERT_EQ(fast.detected_turns.size(), 1u);
  EXPECT_FALSE(fast.detected_turns[0].used);

  // A camera ahead of the front axle would swing outwards; this one swings inwards.
  CarPrior rigid = Exactly({1.5, 0});
  const ScaleEstimateResult inwards = EstimateScale(MakeSteps(TownRoad(3, 9), {-1.5, 0}, 0, kUnit).steps, rigid, {});
  EXPECT_FALSE(inwards.estimate);
  ASSERT_EQ(inwards.detected_turns.size(), 3u);
  EXPECT_NE(inwards.detected_turns[0].reason.find("inside"), std::string::npos) << inwards.detected_turns[0].reason;
  EXPECT_NE(inwards.reason.find("not ahead of the rear axle"), std::string::npos) << inwards.reason;

  CarPrior vague = PriorOf(kCar);
  vague.lever_arm_sigma = 0.5;
  const ScaleEstimateResult uncertain = EstimateScale(MakeSteps(TownRoad(3, 9), kCar, 0, kUnit).steps, vague, {});
  EXPECT_FALSE(uncertain.estimate);
  EXPECT_NE(uncertain.reason.find("uncertain by 3"), std::string::npos) << uncertain.reason;
  EXPECT_NE(uncertain.reason.find("+-0.5 m, is itself too uncertain"), std::string::npos) << uncertain.reason;
  EXPECT_EQ(uncertain.detected_turns.size(), 3u);
}

// One turn of eight whose effective lever arm is wrong by a fifth: within what Huber's weight takes.
TEST(ScaleEstimator, OneTurnThatSkidsHasLittleSay) {
  std::vector<StretchOfRoad> road = TownRoad(8, 10);
  const SyntheticSteps clean = MakeSteps(road, kCar, 0, kUnit, kNoise, 10);
  SyntheticSteps skid = clean;
  const ScaleEstimate before = EstimateOf(clean, Exactly(kCar));
  const TurnEstimate& turn = before.turns[3];
  for (int i = turn.first_step; i <= turn.last_step; ++i) {
    TurningMotion& motion = skid.steps[i].motion;
    motion.theta = 0.5 * motion.psi + 1.2 * (motion.theta - 0.5 * motion.psi);
  }
  const ScaleEstimate after = EstimateOf(skid, Exactly(kCar));
  EXPECT_LT(after.turns[3].weight, 0.5);
  EXPECT_GT(after.turns[3].deviation, 1.5) << "its own scale is smaller than the drive's";
  EXPECT_NEAR(Metres(after) / Metres(before), 1, 0.012);
  for (std::size_t i = 0; i < after.turns.size(); ++i) {
    if (i != 3) {
      EXPECT_GT(after.turns[i].weight, 0.6) << i;
    }
  }
}

// As they say themselves.
void ExpectGoesThroughItsTurns(const ScaleEstimate& estimate) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < estimate.segments.size(); ++i) {
    if (!estimate.segments[i].turning) continue;
    const TurnEstimate& turn = estimate.turns[next++];
    if (turn.used_singly) {
      EXPECT_NEAR(estimate.smoothed[i].metres_per_unit() / turn.as_given, 1, 1e-9);
    }
  }
}

TEST(ScaleEstimator, TurnsThatContradictAreUsedSinglyAndCovered) {
  ScaleEstimatorOptions whatever;
  whatever.max_sigma = 1;
  for (int seed = 0; seed < 20; ++seed) {
    std::vector<StretchOfRoad> road = TownRoad(9, 50 + seed);
    const SyntheticSteps drive = MakeSteps(road, kCar, 0, kUnit, kNoise, seed);
    SyntheticSteps wrong = drive;
    const ScaleEstimate clean = EstimateOf(drive, PriorOf(kCar));
    // Each third turn shows half of its lever arm more: odometry whose camera is calibrated wrongly.
    for (std::size_t t = 0; t < clean.turns.size(); t += 3) {
      for (int i = clean.turns[t].first_step; i <= clean.turns[t].last_step; ++i) {
        TurningMotion& motion = wrong.steps[i].motion;
        motion.theta = 0.5 * motion.psi + 1.5 * (motion.theta - 0.5 * motion.psi);
      }
    }
    const ScaleEstimate estimate = EstimateOf(wrong, PriorOf(kCar), whatever);
    EXPECT_FALSE(clean.uses_single_turns) << seed;
    EXPECT_TRUE(estimate.test.contradicted) << seed;
    EXPECT_TRUE(estimate.uses_single_turns) << seed;
    EXPECT_GE(estimate.test.worst_turn, 0);
    EXPECT_GT(estimate.test.disagreement, 0.05);
    const double error = std::log(Metres(estimate) / drive.metres);
    EXPECT_LT(std::abs(error), 1.2 * estimate.length_sigma) << seed;
    ExpectGoesThroughItsTurns(estimate);
  }
}

TEST(ScaleEstimator, UsesSingleTurnsThatAgreeWhereItIsToldTo) {
  const SyntheticSteps drive = MakeSteps(TownRoad(9, 61), kCar, 0, kUnit, kNoise, 61);
  ScaleEstimatorOptions options;
  const ScaleEstimate smoothed = EstimateOf(drive, PriorOf(kCar), options);
  options.uses_single_turns = true;
  const ScaleEstimate single = EstimateOf(drive, PriorOf(kCar), options);
  EXPECT_FALSE(smoothed.uses_single_turns);
  EXPECT_TRUE(single.uses_single_turns);
  EXPECT_FALSE(single.test.contradicted);
  EXPECT_GT(single.length_sigma, smoothed.length_sigma);
  ExpectGoesThroughItsTurns(single);
}

TEST(ScaleEstimator, UsesSingleTurnsWithTheDrivesYawWhereThatOfThePriorIsWrong) {
  const SyntheticSteps drive = MakeSteps(TownRoad(9, 61), kCar, 3 * kDegree, kUnit, kNoise, 61);
  ScaleEstimatorOptions options;
  options.uses_single_turns = true;
  const ScaleEstimate single = EstimateOf(drive, PriorOf(kCar), options);
  EXPECT_TRUE(single.uses_single_turns);
  EXPECT_TRUE(single.yaw_conflict);
  EXPECT_FALSE(single.test.contradicted);
  EXPECT_LT(single.test.disagreement, 0.05);
  EXPECT_NEAR(std::log(Metres(single) / drive.metres), 0, 0.03);
}

TEST(ScaleEstimator, BetweenLossesOfTrackingWithoutATurnFollowsTheEstimate) {
  SyntheticSteps drive = MakeSteps(TownRoad(6, 61), kCar, 0, kUnit, kNoise, 61);
  const std::vector<TurningRegion> turns = FindTurns(drive.steps, {});
  // Two on one straight, and what is between them in another unit.
  const int straight = turns[2].last + 1;
  const int length = turns[3].first - straight;
  const std::array<int, 2> gaps{straight + length / 4, straight + 3 * length / 4};
  for (int i = gaps[0]; i < gaps[1]; ++i) drive.steps[i].motion.step *= 0.5;
  for (const int gap : gaps) LoseTracking(0.3, drive.steps[gap]);
  ScaleEstimatorOptions options;
  const ScaleEstimate smoothed = EstimateOf(drive, PriorOf(kCar), options);
  options.uses_single_turns = true;
  const ScaleEstimate single = EstimateOf(drive, PriorOf(kCar), options);
  EXPECT_TRUE(single.uses_single_turns);
  for (std::size_t i = 0; i < single.segments.size(); ++i) {
    const int first = single.segments[i].first;
    if (first < gaps[0] || first >= gaps[1]) continue;
    EXPECT_EQ(single.smoothed[i].mean[kLogScale], smoothed.smoothed[i].mean[kLogScale]);
    EXPECT_GT(single.smoothed[i].sigma(), smoothed.smoothed[i].sigma());
  }
  for (const TurnEstimate& turn : single.turns)
    EXPECT_NEAR(single.smoothed[turn.segment].metres_per_unit() / turn.as_given, 1, 1e-9);
}

TEST(ScaleEstimator, TheUnitMayChangeWhereTheMapHardlyHangsTogether) {
  // A turn, a straight on which the unit changes by a half, and a turn.
  SyntheticSteps drive =
      MakeSteps({{20, 0, 5, 9}, {25, 4 * kDegree, 0.5, 5}, {40, 0, 5, 9}, {25, -4 * kDegree, 0.5, 5}}, kCar, 0, 5);
  for (std::size_t i = 65; i < drive.steps.size(); ++i) drive.steps[i].motion.step /= 1.5;
  const ScaleEstimate unaware = EstimateOf(drive, PriorOf(kCar));
  EXPECT_GT(std::abs(std::log(Metres(unaware) / drive.metres)), 0.01);
  drive.steps[65].unit_variance = 0.16;
  const ScaleEstimate aware = EstimateOf(drive, PriorOf(kCar));
  EXPECT_LT(std::abs(std::log(Metres(aware) / drive.metres)), 0.005);
  EXPECT_FALSE(aware.uses_single_turns);
  // Without the second turn nothing tells the unit after the change.
  drive.steps.resize(85);
  EXPECT_GT(EstimateOf(drive, PriorOf(kCar)).smoothed.back().sigma(), 0.35);
  // Many small changes add up.
  drive.steps[65].unit_variance = 0;
  const double usual = EstimateOf(drive, PriorOf(kCar)).smoothed.back().sigma();
  for (VehicleStep& step : drive.steps) step.unit_variance = 0.0004;
  const double weak = EstimateOf(drive, PriorOf(kCar)).smoothed.back().sigma();
  EXPECT_GT(weak, 1.5 * usual);
  EXPECT_LT(weak, std::sqrt(0.0004 * 40) + usual);
}

TEST(ScaleEstimator, AGapMayChangeTheUnit) {
  SyntheticSteps drive = MakeSteps(TownRoad(10, 11), kCar, 0, kUnit, kNoise, 11);
  const std::size_t middle = drive.steps.size() / 2;
  for (std::size_t i = middle; i < drive.steps.size(); ++i) {
    drive.steps[i].motion.step *= 0.7;
    drive.metres_per_unit[i] /= 0.7;
  }
  VehicleStep& gap = drive.steps[middle];
  gap.motion = {};
  gap.usable = false;
  gap.after_gap = true;
  gap.gap_sigma = 0.3;
  const ScaleEstimate estimate = EstimateOf(drive, PriorOf(kCar));
  EXPECT_FALSE(estimate.uses_single_turns);
  for (std::size_t i = 0; i < estimate.segments.size(); ++i)
    EXPECT_NEAR(LogError(estimate, drive, i), 0, 0.25 * estimate.smoothed[i].sigma());
  EXPECT_NEAR(estimate.smoothed.back().metres_per_unit() / estimate.smoothed.front().metres_per_unit(), 1 / 0.7,
              0.0035);
}

/// Loses tracking on the straights before so many turns, from the second on; the unit stays.
void LoseTracking(int gaps, const ScaleEstimate& estimate, SyntheticSteps& drive) {
  for (int i = 0; i < gaps; ++i) {
    VehicleStep& gap = drive.steps[estimate.turns[i + 1].first_step - 5];
    gap.motion = {};
    gap.usable = false;
    gap.after_gap = true;
    gap.gap_sigma = 0.5;
  }
}

TEST(ScaleEstimator, TurnsThatScatterWidenSigmaAsMuchWithGaps) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  constexpr int kDrives = 60;
  DriveErrors errors = kNoise;
  errors.lever_arm = 0.06;
  const ScaleEstimatorOptions options = FindingNoLag();
  const auto inflation = [&](int gaps) {
    double sum = 0;
    for (int seed = 1; seed <= kDrives; ++seed) {
      SyntheticSteps drive = MakeSteps(TownRoad(12, seed), kCar, 0, kUnit, errors, seed);
      LoseTracking(gaps, EstimateOf(drive, PriorOf(kCar), options), drive);
      const TurnTest test = EstimateOf(drive, PriorOf(kCar), options).test;
      EXPECT_EQ(test.degrees_of_freedom, 11 - gaps) << seed;
      sum += test.inflation;
    }
    return sum / kDrives;
  };
  const double whole = inflation(0);
  EXPECT_GT(whole, 1.4);
  for (const int gaps : {4, 8}) EXPECT_NEAR(inflation(gaps), whole, 0.12) << gaps;
  EXPECT_EQ(inflation(11), 1) << "each turn has a scale of its own";
}

TEST(ScaleEstimator, ATurnAfterAGapIsTestedIfTheScaleIsKnownThere) {
  const auto degrees_of_freedom = [](double gap_sigma, bool shows_road) {
    SyntheticSteps drive = MakeSteps(TownRoad(6, 3), kCar, 0, kUnit, kNoise, 3);
    if (shows_road) ShowRoad(1.4, {.step = 0.01, .road = 0.01}, 3, drive);
    LoseTracking(3, EstimateOf(drive, PriorOf(kCar)), drive);
    for (VehicleStep& step : drive.steps)
      if (step.after_gap) step.gap_sigma = gap_sigma;
    return EstimateOf(drive, PriorOf(kCar)).test.degrees_of_freedom;
  };
  EXPECT_EQ(degrees_of_freedom(0.5, false), 2);
  EXPECT_EQ(degrees_of_freedom(0.005, false), 5) << "the unit is hardly new";
  EXPECT_EQ(degrees_of_freedom(0.5, true), 5) << "the height above the road has shown the scale";
}

TEST(ScaleEstimator, ALongDriveIsKnownBetterThanAShortOne) {
  const ScaleEstimatorOptions options;
  double last_sigma = 1;
  for (const int turns : {12, 120, 1200}) {
    const SyntheticSteps drive = MakeSteps(TownRoad(turns, 21), kCar, 0, kUnit, AsStated(options), 21);
    const ScaleEstimate estimate = EstimateOf(drive, Exactly(kCar), options);
    EXPECT_TRUE(estimate.converged);
    EXPECT_FALSE(estimate.uses_single_turns);
    EXPECT_EQ(estimate.turns.size(), static_cast<std::size_t>(turns));
    EXPECT_LT(std::abs(std::log(Metres(estimate) / drive.metres)), 2 * estimate.length_sigma) << turns;
    EXPECT_LT(estimate.length_sigma, 0.5 * last_sigma) << turns;
    last_sigma = estimate.length_sigma;
  }
  EXPECT_LT(last_sigma, 0.002);
}

/// Drives whose every constant is off by as much as is stated. Shares of errors within one and two standard deviations.
struct Coverage {
  int drives = 0;
  int uses_single_turns = 0;
  int length_one = 0;
  int length_two = 0;
  int slip_one = 0;
  int slip_two = 0;
  int yaw_one = 0;
  int yaw_two = 0;
};

Coverage Cover(const CarPrior& prior, int turns, double slope, int drives) {
  Coverage coverage;
  const ScaleEstimatorOptions options;
  const DriveErrors errors = AsStated(options);
  for (int seed = 1; seed <= drives; ++seed) {
    Random random(7000 + seed);
    LeverArm truth;
    truth.length = prior.lever_arm + prior.lever_arm_sigma * random.Gaussian();
    do {
      truth.side_slip = prior.side_slip + prior.side_slip_sigma * random.Gaussian();
    } while (truth.side_slip < 0);
    const double direction = prior.yaw_sigma * random.Gaussian();
    const double unit = std::exp(random.Uniform(-2, 4));
    truth.roll_height = std::max(prior.roll_height + prior.roll_height_sigma * random.Gaussian(), 0.0);
    std::vector<StretchOfRoad> road = TownRoad(turns, seed);
    for (StretchOfRoad& stretch : road) stretch.roll = slope;
    const SyntheticSteps drive = MakeSteps(road, truth, direction, unit, errors, seed);
    const ScaleEstimateResult result = EstimateScale(drive.steps, prior, options);
    if (!result.estimate) continue;
    const ScaleEstimate& estimate = *result.estimate;
    ++coverage.drives;
    coverage.uses_single_turns += estimate.uses_single_turns;
    const auto count = [](double error, double sigma, int& one, int& two) {
      one += std::abs(error) <= sigma;
      two += std::abs(error) <= 2 * sigma;
    };
    count(std::log(Metres(estimate) / drive.metres), estimate.length_sigma, coverage.length_one, coverage.length_two);
    count(estimate.car.side_slip - truth.side_slip, estimate.car.side_slip_sigma, coverage.slip_one, coverage.slip_two);
    count(estimate.car.yaw_error + direction, estimate.car.yaw_error_sigma, coverage.yaw_one, coverage.yaw_two);
  }
  return coverage;
}

// Limits of what 400 drives may show of 68.3 and 95.4 %.
void ExpectHonest(int one, int two, int drives, const char* what) {
  const double share_one = one / static_cast<double>(drives);
  const double share_two = two / static_cast<double>(drives);
  EXPECT_GE(share_one, 0.60) << what;
  EXPECT_LE(share_one, 0.76) << what;
  EXPECT_GE(share_two, 0.90) << what;
  EXPECT_LE(share_two, 0.98) << what;
}

TEST(ScaleEstimator, SigmaCoversWhatItSays) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  constexpr int kDrives = 400;
  for (const int turns : {4, 12}) {
    for (const double slip_sigma : {kUsualSideSlipSigma, kGivenSideSlipSigma * kUsualSideSlip}) {
      CarPrior prior = PriorOf(kCar);
      prior.side_slip_sigma = slip_sigma;
      for (const double slope : {0.0, 0.12}) {
        const Coverage coverage = Cover(prior, turns, slope, kDrives);
        SCOPED_TRACE(testing::Message() << turns << " turns, slip +-" << slip_sigma << ", slope " << slope);
        EXPECT_GE(coverage.drives, 0.99 * kDrives);
        EXPECT_LE(coverage.uses_single_turns, 0.01 * kDrives);
        ExpectHonest(coverage.length_one, coverage.length_two, coverage.drives, "length");
        ExpectHonest(coverage.slip_one, coverage.slip_two, coverage.drives, "slip");
        ExpectHonest(coverage.yaw_one, coverage.yaw_two, coverage.drives, "yaw");
      }
    }
  }
}

TEST(ScaleEstimator, RampsShowTheHeightAboveTheRollAxis) {
  LeverArm car = kCar;
  car.roll_height = 1.5;
  const auto drive = [&](double slope) {
    std::vector<StretchOfRoad> road = TownRoad(12, 5);
    int stretches = 0;
    for (StretchOfRoad& stretch : road) stretch.roll = stretches++ < 12 ? slope : -slope;
    return MakeSteps(road, car, 0, kUnit, kNoise, 5);
  };
  const CarRefinement ramps = EstimateOf(drive(0.12), PriorOf(kCar)).car;
  EXPECT_NEAR(ramps.roll_height, car.roll_height, 2 * ramps.roll_height_sigma);
  EXPECT_LT(ramps.roll_height_sigma, 0.2);
  const CarRefinement level = EstimateOf(drive(0), PriorOf(kCar)).car;
  EXPECT_DOUBLE_EQ(level.roll_height, kUsualRollHeight);
  EXPECT_NEAR(level.roll_height_sigma, kUsualRollHeightSigma, 1e-9);
}

CarPrior WithHeight(double height, double sigma, CarPrior prior = {}) {
  prior.camera_height = height;
  prior.camera_height_sigma = sigma;
  return prior;
}

/// One corner, then a long straight.
std::vector<StretchOfRoad> LongStraight() { return {{20, 0, 5, 9}, {30, 3 * kDegree, 0.4, 5}, {900, 0, 6, 10}}; }

TEST(ScaleEstimator, StepsWithoutARoadChangeNothing) {
  const SyntheticSteps drive = MakeSteps(TownRoad(5, 2), kCar, 0.002, kUnit, kNoise, 2);
  const ScaleEstimate estimate = EstimateOf(drive, PriorOf(kCar));
  EXPECT_EQ(estimate.car.camera_height, 0);
  EXPECT_EQ(std::ranges::count(estimate.from_road, 1), 0);
  EXPECT_FALSE(estimate.height_conflict);
  const ScaleEstimate given = EstimateOf(drive, WithHeight(1.5, 0.015, PriorOf(kCar)));
  for (std::size_t i = 0; i < estimate.smoothed.size(); ++i) {
    EXPECT_NEAR(given.smoothed[i].mean[kLogScale], estimate.smoothed[i].mean[kLogScale], 1e-9);
    EXPECT_NEAR(given.smoothed[i].sigma(), estimate.smoothed[i].sigma(), 1e-9);
  }
}

TEST(ScaleEstimator, TheRoadHoldsTheScaleOnALongStraight) {
  const ScaleEstimatorOptions options;
  double alone = 0;
  double with_road = 0;
  double deviations = 0;
  constexpr int kDrives = 30;
  for (int seed = 1; seed <= kDrives; ++seed) {
    SyntheticSteps drive = MakeSteps(LongStraight(), kCar, 0, kUnit, AsStated(options), seed);
    const ScaleEstimate before = EstimateOf(drive, Exactly(kCar));
    ShowRoad(1.4, {.step = options.evidence.road.step_sigma, .road = options.evidence.road.sigma}, 100 + seed, drive);
    const ScaleEstimate after = EstimateOf(drive, Exactly(kCar));
    // The scale at the end against that in the turn.
    const auto drift = [&](const ScaleEstimate& e) {
      return LogError(e, drive, e.segments.size() - 1) - LogError(e, drive, e.turns.at(0).segment);
    };
    alone += drift(before) * drift(before);
    with_road += drift(after) * drift(after);
    const double error = LogError(after, drive, after.segments.size() - 1) / after.smoothed.back().sigma();
    deviations += error * error / kDrives;
    EXPECT_NEAR(std::log(after.car.camera_height / 1.4), 0, 4 * after.car.camera_height_sigma / 1.4) << seed;
    EXPECT_EQ(after.from_road.back(), 1);
    EXPECT_EQ(after.from_road[after.turns.at(0).segment], 0);
  }
  EXPECT_LT(std::sqrt(with_road), 0.4 * std::sqrt(alone));
  EXPECT_GT(std::sqrt(deviations), 0.6);
  EXPECT_LT(std::sqrt(deviations), 1.4);
}

TEST(ScaleEstimator, AHeightAloneGivesTheMetre) {
  SyntheticSteps drive = MakeSteps({{300, 0, 6, 10}}, kCar, 0, kUnit, {.per_100m = 0.01}, 3);
  EXPECT_FALSE(EstimateScale(drive.steps, WithHeight(1.4, 0.014), {}).estimate) << "the road is not seen";
  ShowRoad(1.4, {.step = 0.01, .road = 0.01}, 3, drive);
  const ScaleEstimate estimate = EstimateOf(drive, WithHeight(1.4, 0.014));
  EXPECT_NEAR(Metres(estimate) / drive.metres, 1, 0.015);
  EXPECT_TRUE(estimate.turns.empty());
  EXPECT_EQ(estimate.car.lever_arm, 0);
  EXPECT_EQ(std::ranges::count(estimate.from_road, 0), 0);
  EXPECT_GT(estimate.length_sigma, 0.009) << "no better than the height";
  EXPECT_LT(estimate.length_sigma, 0.02);
  EXPECT_FALSE(estimate.uses_single_turns);
  const ScaleEstimateResult unknown = EstimateScale(drive.steps, PriorOf(kCar), {});
  EXPECT_FALSE(unknown.estimate);
  EXPECT_NE(unknown.reason.find("height"), std::string::npos) << unknown.reason;
}

TEST(ScaleEstimator, TurnsAreNotUsedWithoutALeverArm) {
  SyntheticSteps drive = MakeSteps(TownRoad(5, 2), kCar, 0, kUnit, kNoise, 2);
  ShowRoad(1.4, {.step = 0.01}, 3, drive);
  const ScaleEstimate estimate = EstimateOf(drive, WithHeight(1.4, 0.014));
  EXPECT_NEAR(Metres(estimate) / drive.metres, 1, 0.01);
  ASSERT_EQ(estimate.turns.size(), 5u);
  for (const TurnEstimate& turn : estimate.turns) {
    EXPECT_FALSE(turn.used);
    EXPECT_EQ(turn.reason, "no lever arm given");
  }
}

TEST(ScaleEstimator, AYawThatContradictsTheDriveIsEstimatedWithoutItsPrior) {
  for (const double degrees : {-3.0, -0.5, 0.5, 3.0}) {
    SCOPED_TRACE(degrees);
    const SyntheticSteps drive = MakeSteps(TownRoad(3, 2), kCar, degrees * kDegree, kUnit, kNoise, 3);
    const ScaleEstimate estimate = EstimateOf(drive, PriorOf(kCar));
    ASSERT_EQ(estimate.yaw_conflict.has_value(), std::abs(degrees) > 1);
    EXPECT_NEAR(Metres(estimate) / drive.metres, 1, 0.03);
    EXPECT_FALSE(estimate.uses_single_turns);
    if (!estimate.yaw_conflict) continue;
    EXPECT_NEAR(estimate.yaw_conflict->found, -degrees * kDegree, 0.2 * kDegree);
    EXPECT_LT(estimate.yaw_conflict->found_sigma, 0.2 * kDegree);
    EXPECT_EQ(estimate.yaw_conflict->given_sigma, PriorOf(kCar).yaw_sigma);
  }
}

/// One turn, whose curvature grows and falls slowly.
std::vector<StretchOfRoad> OneTurn() {
  std::vector<StretchOfRoad> road;
  for (const double share : {0.5, 0.75, 1.0, 0.75, 0.5}) road.push_back({6, share * 4 * kDegree, 0.5, 5});
  return road;
}

/// A right angle with a radius of 6 m between short ramps, where the steps are long: they show the direction.
std::vector<StretchOfRoad> SharpCorner() {
  return {{2, 1.6 * kDegree, 1.2, 4}, {33, 2.5 * kDegree, 0.26, 4}, {2, 1.6 * kDegree, 1.2, 4}};
}

TEST(ScaleEstimator, AYawThatASingleTurnContradictsIsEstimatedWithoutItsPrior) {
  for (const auto& road : {OneTurn(), SharpCorner()}) {
    for (const double degrees : {-8.0, -5.0, -3.0, -0.3, 0.3, 3.0, 5.0, 8.0}) {
      for (unsigned seed = 1; seed <= 5; ++seed) {
        SCOPED_TRACE(testing::Message() << degrees << " deg, seed " << seed);
        const SyntheticSteps drive = MakeSteps(road, kCar, degrees * kDegree, kUnit, kNoise, seed);
        const ScaleEstimate estimate = EstimateOf(drive, PriorOf(kCar));
        ASSERT_EQ(estimate.yaw_conflict.has_value(), std::abs(degrees) > 1);
        EXPECT_LT(std::abs(std::log(Metres(estimate) / drive.metres)), 2.5 * estimate.length_sigma);
        EXPECT_LT(estimate.length_sigma, 0.12);
        if (!estimate.yaw_conflict) continue;
        EXPECT_NEAR(estimate.yaw_conflict->found, -degrees * kDegree, 2.5 * estimate.yaw_conflict->found_sigma);
        EXPECT_LT(estimate.yaw_conflict->found_sigma, 0.6 * kDegree);
      }
    }
  }
}

TEST(ScaleEstimator, ARotationThatIsFarOffGivesNoMetres) {
  for (const double degrees : {-20.0, -12.0, 12.0, 20.0}) {
    SCOPED_TRACE(degrees);
    const SyntheticSteps drive = MakeSteps(SharpCorner(), kCar, degrees * kDegree, kUnit, kNoise, 1);
    const ScaleEstimateResult result = EstimateScale(drive.steps, PriorOf(kCar), {});
    EXPECT_FALSE(result.estimate);
    EXPECT_FALSE(result.reason.empty());
    for (const TurnEstimate& turn : result.detected_turns) EXPECT_FALSE(turn.used);
  }
}

TEST(ScaleEstimator, AWrongLeverArmShowsInTheHeight) {
  SyntheticSteps drive = MakeSteps(TownRoad(8, 4), kCar, 0, kUnit, kNoise, 4);
  ShowRoad(1.4, {.step = 0.01, .road = 0.01}, 5, drive);
  EXPECT_FALSE(EstimateOf(drive, WithHeight(1.4, 0.014, PriorOf(kCar))).height_conflict);
  CarPrior wrong = WithHeight(1.4, 0.014, PriorOf(kCar));
  wrong.lever_arm *= 1.2;
  const ScaleEstimate estimate = EstimateOf(drive, wrong);
  ASSERT_TRUE(estimate.height_conflict);
  EXPECT_EQ(estimate.height_conflict->given, 1.4);
  EXPECT_NEAR(estimate.height_conflict->found / 1.4, 1.2, 0.06);
  EXPECT_GT(estimate.length_sigma, 0.08) << "it may be either";
}

// A wrong length bends the estimate from both, but not what is said of it.
TEST(ScaleEstimator, TheHeightFoundIsProportionalToTheLeverArm) {
  SyntheticSteps drive = MakeSteps(TownRoad(8, 4), kCar, 0, kUnit, kNoise, 4);
  ShowRoad(1.4, {.step = 0.01, .road = 0.01}, 5, drive);
  for (const double wrong : {1.3, 1.5, 2.0}) {
    CarPrior car = WithHeight(1.4, 0.014, PriorOf(kCar));
    car.lever_arm *= wrong;
    car.side_slip *= wrong;
    const ScaleEstimate estimate = EstimateOf(drive, car);
    ASSERT_TRUE(estimate.height_conflict) << wrong;
    EXPECT_NEAR(estimate.height_conflict->found / 1.4, wrong, 0.04 * wrong);
  }
}

/// Lever arm and height known to 2 %, with errors that correlate as in a car file.
CarPrior WithCorrelatedHeight(double correlation, double slip_correlation) {
  CarPrior prior = WithHeight(1.4, 0.02 * 1.4, PriorOf(kCar));
  prior.lever_arm_sigma = 0.02 * kCar.length;
  prior.height_correlation = correlation;
  prior.height_slip_correlation = slip_correlation;
  return prior;
}

struct HeightCorrelations {
  double with_lever_arm;
  double with_slip;
};
constexpr HeightCorrelations kHeightCorrelations[] = {{0, 0}, {0.7, 0}, {0.9, 0}, {0.7, -0.5}};

TEST(ScaleEstimator, TheHeightFoundIsThatOfTheTurnsHoweverThePriorsCorrelate) {
  for (const auto& [with_lever_arm, with_slip] : kHeightCorrelations) {
    const CarPrior prior = WithCorrelatedHeight(with_lever_arm, with_slip);
    for (const double height : {1.2, 1.6}) {
      for (int seed = 1; seed <= 5; ++seed) {
        SyntheticSteps drive = MakeSteps(TownRoad(8, seed), kCar, 0, kUnit, kNoise, seed);
        ShowRoad(height, {.step = 0.01, .road = 0.01}, seed, drive);
        const ScaleEstimate estimate = EstimateOf(drive, prior);
        SCOPED_TRACE(testing::Message() << with_lever_arm << ' ' << with_slip << ' ' << height << ' ' << seed);
        ASSERT_TRUE(estimate.height_conflict);
        EXPECT_NEAR(estimate.height_conflict->found / height, 1, 0.03);
        EXPECT_GT(estimate.height_conflict->found_sigma / height, 0.02) << "no better than the lever arm";
        EXPECT_LT(estimate.height_conflict->found_sigma / height, 0.04);
        const double difference = std::abs(std::log(height / 1.4));
        EXPECT_GT(estimate.length_sigma, (estimate.height_conflict->contradicts_turns ? 0.6 : 0.4) * difference);
        EXPECT_LT(estimate.length_sigma, estimate.uses_single_turns ? 0.2 : 0.12);
      }
    }
  }
}

TEST(ScaleEstimator, TyresDoNotSlipInwardsHoweverTheHeightCorrelates) {
  for (const double correlation : {0.0, -0.5, 0.5}) {
    CarPrior prior = WithCorrelatedHeight(0.5, correlation);
    prior.side_slip = 0.001;
    SyntheticSteps drive = MakeSteps(TownRoad(8, 4), {kCar.length, -0.004}, 0, kUnit, kNoise, 4);
    ShowRoad(1.4, {.step = 0.01, .road = 0.01}, 5, drive);
    const ScaleEstimate estimate = EstimateOf(drive, prior);
    SCOPED_TRACE(correlation);
    EXPECT_TRUE(estimate.converged);
    EXPECT_TRUE(estimate.car.side_slip_at_bound);
    for (const ScaleBelief& belief : estimate.smoothed) EXPECT_NEAR(belief.mean[kSlip], 0, 1e-7);
    EXPECT_NEAR(estimate.car.camera_height, 1.4, 2 * estimate.car.camera_height_sigma);
  }
}

TEST(ScaleEstimator, LengthsThatAreWrongWithinTheirSigmasAreNoConflict) {
  const ScaleEstimatorOptions options;
  for (const auto& [with_lever_arm, with_slip] : kHeightCorrelations) {
    const CarPrior prior = WithCorrelatedHeight(with_lever_arm, with_slip);
    const double alone = std::sqrt(1 - with_lever_arm * with_lever_arm - with_slip * with_slip);
    int conflicts = 0;
    for (int seed = 1; seed <= 100; ++seed) {
      Random random(300 + seed);
      const double arm = random.Gaussian();
      const double slip = std::max(random.Gaussian(), -prior.side_slip / prior.side_slip_sigma);
      const double height = with_lever_arm * arm + with_slip * slip + alone * random.Gaussian();
      const LeverArm car{prior.lever_arm + prior.lever_arm_sigma * arm, prior.side_slip + prior.side_slip_sigma * slip};
      SyntheticSteps drive = MakeSteps(TownRoad(8, seed), car, 0, kUnit, AsStated(options), seed);
      ShowRoad(prior.camera_height + prior.camera_height_sigma * height,
               {.step = options.evidence.road.step_sigma, .road = options.evidence.road.sigma}, seed, drive);
      conflicts += EstimateOf(drive, prior, options).height_conflict ? 1 : 0;
    }
    EXPECT_LE(conflicts, 2) << with_lever_arm << ' ' << with_slip;
  }
}

// The road and the turns show different scales: the turns disagree with the estimate, but not with each other.
TEST(ScaleEstimator, AWrongHeightIsNotBlamedOnTheTurns) {
  for (const double wrong : {1.3, 0.75}) {
    int contradicted = 0;
    for (int seed = 1; seed <= 8; ++seed) {
      SyntheticSteps drive = MakeSteps(TownRoad(8, seed), kCar, 0, kUnit, kNoise, seed);
      ShowRoad(1.4, {.step = 0.01, .road = 0.01}, 5, drive);
      const ScaleEstimate estimate = EstimateOf(drive, WithHeight(wrong * 1.4, wrong * 0.014, PriorOf(kCar)));
      ASSERT_TRUE(estimate.height_conflict) << seed;
      EXPECT_FALSE(estimate.test.contradicted) << seed;
      EXPECT_FALSE(estimate.uses_single_turns) << seed;
      EXPECT_FALSE(estimate.has_reliable_car()) << seed;
      EXPECT_NEAR(estimate.height_conflict->found / 1.4, 1, 0.05) << seed;
      EXPECT_LT(std::abs(std::log(Metres(estimate) / drive.metres)), 2 * estimate.length_sigma) << seed;
      if (!estimate.height_conflict->contradicts_turns) continue;
      ++contradicted;
      EXPECT_NEAR(Metres(estimate) / drive.metres, 1, 0.05) << seed << ": by the lever arm";
    }
    EXPECT_GT(contradicted, 0) << wrong;
  }
}

TEST(ScaleEstimator, TurnsThatDisagreeWithEachOtherAreNotBlamedOnTheHeight) {
  SyntheticSteps drive = MakeSteps(TownRoad(9, 50), kCar, 0, kUnit, kNoise, 1);
  ShowRoad(1.4, {.step = 0.01, .road = 0.01}, 5, drive);
  const ScaleEstimate clean = EstimateOf(drive, PriorOf(kCar));
  for (std::size_t t = 0; t < clean.turns.size(); t += 3) {
    for (int i = clean.turns[t].first_step; i <= clean.turns[t].last_step; ++i) {
      TurningMotion& motion = drive.steps[i].motion;
      motion.theta = 0.5 * motion.psi + 1.5 * (motion.theta - 0.5 * motion.psi);
    }
  }
  const ScaleEstimate estimate = EstimateOf(drive, WithHeight(1.3 * 1.4, 1.3 * 0.014, PriorOf(kCar)));
  ASSERT_TRUE(estimate.height_conflict);
  EXPECT_TRUE(estimate.test.contradicted);
  EXPECT_FALSE(estimate.height_conflict->contradicts_turns);
}

// Scaled to about one standard deviation of each constant.
Eigen::Matrix4d Information(const CarEvidence& evidence) {
  const Eigen::Vector4d scale(0.005, 0.002, 0.03, 0.1);
  const Eigen::Matrix4d told = evidence.posterior.covariance.inverse() - evidence.prior.covariance.inverse();
  return scale.asDiagonal() * told * scale.asDiagonal();
}

TEST(ScaleEstimator, WhatADriveTellsOfTheCarDoesNotDependOnThePrior) {
  SyntheticSteps drive = MakeSteps(TownRoad(6, 4), kCar, 0, kUnit, {}, 4);
  ShowRoad(1.4, {}, 5, drive);
  CarPrior wide = PriorOf(kCar);
  CarPrior narrow = WithHeight(1.4, 0.1, PriorOf(kCar));
  narrow.side_slip_sigma = 0.5 * wide.side_slip_sigma;
  narrow.yaw_sigma = 0.5 * wide.yaw_sigma;
  narrow.height_slip_correlation = -0.5;
  const Eigen::Matrix4d of_wide = Information(EstimateOf(drive, wide).car_evidence);
  const Eigen::Matrix4d of_narrow = Information(EstimateOf(drive, narrow).car_evidence);
  EXPECT_GT(of_wide(1, 1), 1) << "the turns tell c";
  EXPECT_LT((of_wide - of_narrow).norm(), 0.02 * of_wide.norm()) << of_wide << "\n\n" << of_narrow;
}

TEST(ScaleEstimator, TheCarTellsHowTheErrorsOfTheHeightCorrelate) {
  SyntheticSteps drive = MakeSteps(TownRoad(6, 4), kCar, 0, kUnit, {}, 4);
  ShowRoad(1.4, {}, 5, drive);
  CarPrior prior = PriorOf(kCar);
  const ScaleEstimate estimate = EstimateOf(drive, prior);
  ASSERT_GT(estimate.car.camera_height, 0);
  const Eigen::Matrix4d& covariance = estimate.car_evidence.posterior.covariance;
  const auto correlation = [&](int i) { return covariance(i, 3) / std::sqrt(covariance(i, i) * covariance(3, 3)); };
  EXPECT_NEAR(estimate.car.height_slip_correlation, correlation(1), 1e-9);
  EXPECT_NEAR(estimate.car.height_correlation, correlation(2), 1e-9);
  EXPECT_LT(estimate.car.height_slip_correlation, -0.05) << "more slip is less height";
  prior.side_slip_sigma = 0;
  EXPECT_EQ(EstimateOf(drive, prior).car.height_slip_correlation, 0);
}

// Prior as from a calibration at the speed of the drive: L - c v^2 is known better than L.
TEST(ScaleEstimator, ALeverArmThatErrsWithTheSlipShowsTheScaleAtItsSpeed) {
  constexpr double kSpeed = 7;
  CarPrior prior = PriorOf(kCar);
  const double exact = 0.02;
  prior.lever_arm_sigma = std::hypot(exact, kSpeed * kSpeed * prior.side_slip_sigma);
  const auto sigma_of_effective = [&](const CarPrior& car) {
    const ScaleBelief belief = PriorBelief(car, 0);
    DriveState by_state = DriveState::Zero();
    by_state[kLogLeverArm] = car.lever_arm;
    by_state[kSlip] = -kSpeed * kSpeed;
    return std::sqrt(by_state.dot(belief.covariance * by_state));
  };
  EXPECT_GT(sigma_of_effective(prior), 5 * exact) << "counted twice";
  prior.lever_arm_slip_correlation = kSpeed * kSpeed * prior.side_slip_sigma / prior.lever_arm_sigma;
  EXPECT_NEAR(sigma_of_effective(prior), exact, 1e-6);
  const SyntheticSteps drive = MakeSteps(TownRoad(8, 4), kCar, 0, kUnit, kNoise, 4);
  CarPrior independent = prior;
  independent.lever_arm_slip_correlation = 0;
  EXPECT_LT(EstimateOf(drive, prior).length_sigma, 0.9 * EstimateOf(drive, independent).length_sigma);
}

TEST(ScaleEstimator, TheCarTellsHowLeverArmAndSlipErrTogether) {
  const SyntheticSteps drive = MakeSteps(TownRoad(6, 4), kCar, 0, kUnit, {}, 4);
  CarPrior prior = PriorOf(kCar);
  prior.lever_arm_slip_correlation = 0.9;
  const ScaleEstimate estimate = EstimateOf(drive, prior);
  const Eigen::Matrix4d& covariance = estimate.car_evidence.posterior.covariance;
  EXPECT_NEAR(estimate.car.lever_arm_slip_correlation,
              covariance(1, 2) / std::sqrt(covariance(1, 1) * covariance(2, 2)), 1e-9);
  prior.lever_arm_slip_correlation = prior.side_slip_sigma = 0;
  EXPECT_EQ(EstimateOf(drive, prior).car.lever_arm_slip_correlation, 0);
}

TEST(CarPrior, ErrorsCorrelateAsThreeErrorsCan) {
  EXPECT_TRUE(CanCorrelate(0.9, 0.9, 0.9));
  EXPECT_FALSE(CanCorrelate(0.9, -0.9, 0.9));
  EXPECT_FALSE(CanCorrelate(0.9, 0.9, 0));
  EXPECT_FALSE(CanCorrelate(0, 0, 1));
  EXPECT_FALSE(CanCorrelate(1, 0, 0));
  CarPrior prior = WithHeight(1.4, 0.02, PriorOf(kCar));
  prior.lever_arm_slip_correlation = 1.1;
  EXPECT_THROW(prior.Check(), InputError);
}

TEST(ScaleEstimator, WhatADriveTellsOfTheCarMayBeANegativeSlip) {
  const SyntheticSteps drive = MakeSteps(TownRoad(8, 4), {kCar.length, -0.004}, 0, kUnit, {}, 4);
  const ScaleEstimate estimate = EstimateOf(drive, PriorOf({kCar.length, 0.001}), FindingNoLag());
  ASSERT_TRUE(estimate.car.side_slip_at_bound);
  EXPECT_EQ(estimate.car.side_slip, 0);
  EXPECT_LT(estimate.car_evidence.posterior.mean[1], 0);
}

TEST(ScaleEstimatorOptions, RefusesSenselessValues) {
  const auto refused = [](auto change) { return RefusedField<ScaleEstimatorOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.huber = 0; }), "huber");
  EXPECT_EQ(refused([](auto& o) { o.max_sigma = 0; }), "max_sigma");
  EXPECT_EQ(refused([](auto& o) { o.max_given_yaw_sigma = 0; }), "max_given_yaw_sigma_deg");
  EXPECT_EQ(refused([](auto& o) { o.max_turn_yaw_deviation = 0; }), "max_turn_yaw_deviation");
  EXPECT_EQ(refused([](auto& o) { o.segments.max_straight_steps = 0; }), "max_straight_steps");
  EXPECT_EQ(refused([](auto& o) { o.evidence.turn_sigma = 0; }), "evidence.turn_sigma");
  EXPECT_EQ(refused([](auto& o) { o.drift.per_100m = -1; }), "drift.per_100m");
  EXPECT_EQ(refused([](auto& o) { o.test.min_probability = 0; }), "test.min_probability");
  EXPECT_EQ(refused([](auto& o) { o.stabilisation.min_lag_deviation = 0; }), "stabilisation.min_lag_deviation");
}

}  // namespace
}  // namespace turnscale
