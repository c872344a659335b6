// SPDX-License-Identifier: MIT
#include "turnscale/scale/live_scale.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/scale/synthetic_steps.h"

namespace turnscale {
namespace {

CarPrior Prior() {
  CarPrior prior;
  prior.lever_arm = kCar.length;
  prior.side_slip = kCar.side_slip;
  return prior;
}

std::vector<StretchOfRoad> OneCorner() { return {{20, 0, 5, 9}, {30, 3 * kDegree, 0.4, 5}, {30, 0, 5, 9}}; }

std::optional<ScaleBelief> BeliefOf(const LiveScale& live) {
  return live.Now() ? std::optional(live.Now()->belief) : std::nullopt;
}

bool IsInTurn(const LiveScale& live) { return live.Now() && live.Now()->state == ScaleState::kObserved; }

/// What is known after each step.
std::vector<std::optional<ScaleBelief>> Live(const std::vector<VehicleStep>& steps, const CarPrior& prior = Prior()) {
  LiveScale live(prior, {});
  std::vector<std::optional<ScaleBelief>> beliefs;
  for (const VehicleStep& step : steps) {
    live.Add(step);
    beliefs.push_back(BeliefOf(live));
  }
  return beliefs;
}

TEST(LiveScale, KnowsTheMetreInsideTheFirstTurn) {
  const SyntheticSteps drive = MakeSteps(OneCorner(), kCar, 0, kUnit, kNoise);
  LiveScale live(Prior(), {});
  int known_at = -1;
  double last_sigma = 1;
  for (int i = 0; i < static_cast<int>(drive.steps.size()); ++i) {
    const TurnEnd end = live.Add(drive.steps[i]);
    EXPECT_EQ(end, i == 51 ? TurnEnd::kUsed : TurnEnd::kNone) << "two weak steps after its last, step 49";
    const std::optional<ScaleBelief> now = BeliefOf(live);
    if (!now) {
      EXPECT_EQ(known_at, -1) << "what is known stays known";
      continue;
    }
    if (known_at < 0) known_at = i;
    EXPECT_LE(now->sigma(), 0.15);
    EXPECT_NEAR(std::log(now->metres_per_unit() / kUnit), 0, 0.2 * now->sigma());
    EXPECT_EQ(live.Now()->state, i <= 50 ? ScaleState::kObserved : ScaleState::kHeld) << i;
    if (i > known_at && i < 50) {
      EXPECT_LE(now->sigma(), 1.02 * last_sigma) << "better with every step of the turn";
    }
    last_sigma = now->sigma();
  }
  EXPECT_GE(known_at, 20 + 4) << "15 degrees make a turn";
  EXPECT_LT(known_at, 20 + 15) << "half-way through it";
}

TEST(LiveScale, WaitsForFifteenPercent) {
  const std::vector<VehicleStep> steps = MakeSteps(OneCorner(), kCar, 0, kUnit, kNoise).steps;
  CarPrior vague = Prior();
  vague.lever_arm_sigma = 0.2 * kCar.length;
  LiveScale live(vague, {});
  for (const VehicleStep& step : steps) {
    live.Add(step);
    EXPECT_FALSE(live.Now()) << "the lever arm alone is worth 20 %";
  }
  ScaleEstimatorOptions generous;
  generous.max_sigma = 0.3;
  LiveScale content(vague, generous);
  for (const VehicleStep& step : steps) content.Add(step);
  EXPECT_TRUE(content.Now());
}

TEST(LiveScale, IsNotKnownWithoutATurn) {
  for (const auto& belief : Live(MakeSteps({{200, 0, 5, 9}, {50, 0.5 * kDegree, 5, 9}}, kCar, 0, kUnit).steps))
    EXPECT_FALSE(belief);
}

TEST(LiveScale, AKnownHeightGivesTheMetreFromTheFirstSteps) {
  CarPrior prior;
  prior.camera_height = 1.5;
  prior.camera_height_sigma = 0.015;
  SyntheticSteps drive = MakeSteps({{200, 0, 5, 9}}, kCar, 0, kUnit, {.per_100m = 0.01});
  ShowRoad(1.5, {.step = 0.01, .road = 0.01}, 3, drive);
  LiveScale live(prior, {});
  for (int i = 0; i < 200; ++i) {
    live.Add(drive.steps[i]);
    if (i < 5) continue;
    ASSERT_TRUE(live.Now()) << i;
    EXPECT_EQ(live.Now()->state, ScaleState::kFromRoad);
    EXPECT_NEAR(std::log(live.Now()->belief.metres_per_unit() / drive.metres_per_unit[i]), 0, 0.05) << i;
    EXPECT_LT(live.Now()->belief.sigma(), 0.03);
  }
}

TEST(LiveScale, AHeightLearnedInATurnHoldsTheScale) {
  const std::vector<StretchOfRoad> road{{20, 0, 5, 9}, {30, 3 * kDegree, 0.4, 5}, {800, 0, 5, 9}};
  SyntheticSteps drive = MakeSteps(road, kCar, 0, kUnit, {.per_100m = 0.01});
  const auto alone = Live(drive.steps).back();
  ShowRoad(1.3, {.step = 0.01, .road = 0.01}, 4, drive);
  LiveScale live(Prior(), {});
  for (const VehicleStep& step : drive.steps) live.Add(step);
  ASSERT_TRUE(live.Now() && alone);
  EXPECT_EQ(live.Now()->state, ScaleState::kFromRoad);
  const ScaleBelief& now = live.Now()->belief;
  EXPECT_NEAR(std::exp(now.mean[kLogHeight]), 1.3, 4 * 1.3 * now.Sigma(kLogHeight));
  EXPECT_LT(now.sigma(), 0.6 * alone->sigma());
  EXPECT_NEAR(std::log(now.metres_per_unit() / drive.metres_per_unit.back()), 0, 3 * now.sigma());
}

TEST(LiveScale, AKnownHeightAndATurnAreMoreThanEither) {
  SyntheticSteps drive = MakeSteps(OneCorner(), kCar, 0, kUnit, kNoise);
  const auto turn = Live(drive.steps);
  ShowRoad(1.5, {.step = 0.01, .road = 0.01}, 3, drive);
  CarPrior height_only;
  height_only.camera_height = 1.5;
  height_only.camera_height_sigma = 0.015;
  const auto height = Live(drive.steps, height_only);
  CarPrior with_both = Prior();
  with_both.camera_height = height_only.camera_height;
  with_both.camera_height_sigma = height_only.camera_height_sigma;
  const auto both = Live(drive.steps, with_both);
  for (const std::size_t last : {std::size_t{49}, drive.steps.size() - 1}) {  // of the turn, of the drive
    ASSERT_TRUE(turn[last] && height[last] && both[last]) << last;
    EXPECT_LT(both[last]->sigma(), std::min(turn[last]->sigma(), height[last]->sigma())) << last;
    EXPECT_NEAR(std::log(both[last]->metres_per_unit() / kUnit), 0, 3 * both[last]->sigma()) << last;
  }
}

// Before the road is seen, the unit of the map says nothing of the height.
TEST(LiveScale, ARoadThatIsSeenAfterTheFirstTurnGivesTheSameMetresInAnyUnit) {
  const auto last = [](double unit) {
    SyntheticSteps drive = MakeSteps({{20, 0, 5, 9}, {30, 3 * kDegree, 0.4, 5}, {60, 0, 5, 9}}, kCar, 0, unit, kNoise);
    ShowRoad(1.3, {.step = 0.01}, 4, drive);
    for (int i = 0; i < 52; ++i) drive.steps[i].height = 0;
    return Live(drive.steps).back().value();
  };
  const ScaleBelief one = last(1);
  for (const double unit : {0.01, 12.0, 5000.0}) {
    const ScaleBelief belief = last(unit);
    EXPECT_NEAR(belief.metres_per_unit() / unit, one.metres_per_unit(), 1e-6) << unit;
    EXPECT_NEAR(belief.mean[kLogHeight], one.mean[kLogHeight], 1e-6) << unit;
  }
}

TEST(LiveScale, ARoadThatIsSeenBeforeTheFirstTurnGivesTheSameMetresInAnyUnit) {
  const auto last = [](double unit) {
    SyntheticSteps drive = MakeSteps({{60, 0, 5, 9}, {30, 3 * kDegree, 0.4, 5}, {20, 0, 5, 9}}, kCar, 0, unit, kNoise);
    ShowRoad(1.3, {.step = 0.01}, 4, drive);
    return Live(drive.steps).back().value();
  };
  const ScaleBelief one = last(1);
  EXPECT_NEAR(std::log(one.metres_per_unit()), 0, 2 * one.sigma());
  for (const double unit : {0.001, 0.05, 20.0, 1000.0}) {
    const ScaleBelief belief = last(unit);
    EXPECT_NEAR(belief.metres_per_unit() / unit, one.metres_per_unit(), 1e-3) << unit;
    EXPECT_NEAR(belief.mean[kLogHeight], one.mean[kLogHeight], 1e-3) << unit;
  }
}

// Nothing but the height gives the scale: the corner is a turn that is not used.
TEST(LiveScale, ATurnThatIsNotUsedDoesNotObserveTheScale) {
  SyntheticSteps drive = MakeSteps(OneCorner(), kCar, 0, kUnit, kNoise);
  ShowRoad(1.5, {.step = 0.01}, 3, drive);
  CarPrior height_only;
  height_only.camera_height = 1.5;
  height_only.camera_height_sigma = 0.015;
  LiveScale live(height_only, {});
  std::vector<TurnEnd> ends;
  for (const VehicleStep& step : drive.steps) {
    const TurnEnd end = live.Add(step);
    if (end != TurnEnd::kNone) ends.push_back(end);
    EXPECT_FALSE(IsInTurn(live));
  }
  EXPECT_EQ(ends, std::vector{TurnEnd::kNotUsed});
  EXPECT_TRUE(live.Now());
}

TEST(LiveScale, StaysMetricWhenTheFirstTurnGetsTooFast) {
  // 15 degrees at 3 m/s, then a bend of 60 m at 14 m/s, where slip takes the lever arm.
  const std::vector<StretchOfRoad> corner{{20, 0, 5, 9}, {10, 2.5 * kDegree, 0.6, 3}, {30, 2.5 * kDegree, 2.6, 14}};
  std::vector<StretchOfRoad> road = corner;
  road.push_back({60, 0, 5, 9});
  const LeverArm arm{1.0, 0.0045};
  CarPrior prior;
  prior.lever_arm = arm.length;
  prior.side_slip = arm.side_slip;
  const std::vector<VehicleStep> steps = MakeSteps(road, arm, 0, kUnit).steps;
  LiveScale live(prior, {});
  bool known = false;
  bool ended = false;
  for (const VehicleStep& step : steps) {
    const TurnEnd end = live.Add(step);
    ended = ended || end != TurnEnd::kNone;
    EXPECT_NE(end, TurnEnd::kUsed);
    if (known) {
      ASSERT_TRUE(live.Now());
      EXPECT_NEAR(std::log(live.Now()->belief.metres_per_unit() / kUnit), 0, 2 * live.Now()->belief.sigma());
    }
    known = live.Now().has_value();
  }
  EXPECT_TRUE(known && ended);
  EXPECT_EQ(live.Now()->state, ScaleState::kHeld);
}

// As in the smoother.
TEST(LiveScale, ATurnThatIsTooFastShowsTheDirectionOfTravel) {
  CarPrior prior = Prior();
  prior.yaw_sigma = 0.5 * kDegree;
  ScaleEstimatorOptions options;
  options.evidence.straight_direction_sigma = 3 * kDegree;
  LiveScale live(prior, options);
  TurnEnd last_end = TurnEnd::kNone;
  const auto direction_sigma_after = [&](const std::vector<StretchOfRoad>& road) {
    for (const VehicleStep& step : MakeSteps(road, {1.5, 0.005}, 0, kUnit, kNoise).steps) {
      const TurnEnd end = live.Add(step);
      if (end != TurnEnd::kNone) last_end = end;
    }
    return live.Now().value().belief.Sigma(kDirection);
  };
  const double slow = direction_sigma_after({{10, 0, 2, 5}, {30, 3 * kDegree, 0.4, 5}, {10, 0, 2, 5}});
  const double fast = direction_sigma_after({{10, 0, 2, 10},
                                             {20, 2 * kDegree, 0.4, 16.5},
                                             {20, 4 * kDegree, 3, 16.5},
                                             {20, kDegree, 3, 16.5},
                                             {10, 0, 2, 10}});
  EXPECT_EQ(last_end, TurnEnd::kNotUsed);
  EXPECT_LT(fast, 0.9 * slow);
}

TEST(LiveScale, AnUnknownHeightIsNoScale) {
  SyntheticSteps drive = MakeSteps({{200, 0, 5, 9}}, kCar, 0, kUnit);
  ShowRoad(1.5, {}, 3, drive);
  for (const auto& belief : Live(drive.steps)) EXPECT_FALSE(belief);
}

TEST(LiveScale, StraightsCostCertainty) {
  const std::vector<VehicleStep> steps =
      MakeSteps({{20, 0, 5, 9}, {30, 3 * kDegree, 0.4, 5}, {200, 0, 5, 9}}, kCar, 0, kUnit).steps;
  CarPrior prior = Prior();
  prior.yaw_sigma = 1e-6;
  const auto beliefs = Live(steps, prior);
  double last = 0;
  for (std::size_t i = 52; i < steps.size(); ++i) {
    ASSERT_TRUE(beliefs[i]);
    EXPECT_GT(beliefs[i]->sigma(), last);
    last = beliefs[i]->sigma();
    EXPECT_NEAR(beliefs[i]->metres_per_unit(), beliefs[52]->metres_per_unit(), 1e-9) << "and do not change it";
  }
  // 198 steps of 5 m at 1 % in 100 m.
  EXPECT_NEAR(std::pow(last, 2) - std::pow(beliefs[52]->sigma(), 2), 1e-4 * 197 * 5 / 100, 2e-6);
}

TEST(LiveScale, StraightsShowTheDirectionOfTravel) {
  constexpr double kOff = 2 * kDegree;
  CarPrior prior = Prior();
  prior.yaw_sigma = 3 * kDegree;
  const auto drive = [&](int before, int after) {
    return Live(
        MakeSteps({{before, 0, 5, 9}, {30, 3 * kDegree, 0.4, 5}, {after, 0, 5, 9}}, kCar, kOff, kUnit, kNoise, 4).steps,
        prior);
  };
  const auto sigma = [](const ScaleBelief& belief) { return std::sqrt(belief.covariance(kDirection, kDirection)); };
  // From the one before the first turn, whose length in metres is guessed.
  const auto straight_first = drive(60, 5);
  ASSERT_TRUE(straight_first.back());
  EXPECT_LT(sigma(*straight_first.back()), 0.16 * kDegree);
  EXPECT_NEAR(straight_first.back()->mean[kDirection], kOff, 0.5 * sigma(*straight_first.back()));
  EXPECT_NEAR(std::log(straight_first.back()->metres_per_unit() / kUnit), 0, 0.02);
  // From the one after it.
  const auto turn_first = drive(2, 120);
  EXPECT_FALSE(turn_first[35]) << "a turn alone does not tell the direction of travel from the lever arm";
  ASSERT_TRUE(turn_first.back());
  EXPECT_NEAR(turn_first.back()->mean[kDirection], kOff, 0.5 * sigma(*turn_first.back()));
  EXPECT_NEAR(std::log(turn_first.back()->metres_per_unit() / kUnit), 0, 0.02);
}

TEST(LiveScale, AGapWidensSigma) {
  std::vector<VehicleStep> steps = MakeSteps(OneCorner(), kCar, 0, kUnit).steps;
  steps[60].motion = {};
  steps[60].usable = false;
  steps[60].after_gap = true;
  steps[60].gap_sigma = 0.1;
  const auto beliefs = Live(steps);
  ASSERT_TRUE(beliefs[59] && beliefs[60]);
  // The straight before the gap ends there, and shows the direction of travel.
  EXPECT_NEAR(std::pow(beliefs[60]->sigma(), 2) - std::pow(beliefs[59]->sigma(), 2), 0.01, 1e-4);
  EXPECT_NEAR(beliefs[60]->metres_per_unit(), beliefs[59]->metres_per_unit(), 1e-4);
  steps[60].gap_sigma = 0.5;
  const auto lost = Live(steps);
  ASSERT_TRUE(lost[60]) << "metres stay metres, however coarse";
  EXPECT_GT(lost[60]->sigma(), 0.5);
}

TEST(LiveScale, AStepOverWhichTheUnitMayChangeWidensSigma) {
  std::vector<VehicleStep> steps = MakeSteps(OneCorner(), kCar, 0, kUnit).steps;
  steps[60].unit_variance = 0.01;
  const auto beliefs = Live(steps);
  ASSERT_TRUE(beliefs[59] && beliefs[60]);
  EXPECT_NEAR(std::pow(beliefs[60]->sigma(), 2) - std::pow(beliefs[59]->sigma(), 2), 0.01, 1e-4);
  EXPECT_NEAR(beliefs[60]->metres_per_unit(), beliefs[59]->metres_per_unit(), 1e-4);
}

TEST(LiveScale, ATurnAfterAGapSaysItsOwnScale) {
  std::vector<VehicleStep> steps = MakeSteps(OneCorner(), kCar, 0, kUnit).steps;
  std::vector<VehicleStep> after = MakeSteps(OneCorner(), kCar, 0, 20).steps;
  after[0].motion = {};
  after[0].usable = false;
  after[0].after_gap = true;
  after[0].gap_sigma = 0.5;
  steps.insert(steps.end(), after.begin(), after.end());
  const auto beliefs = Live(steps);
  ASSERT_TRUE(beliefs.back());
  EXPECT_NEAR(beliefs.back()->metres_per_unit() / 20, 1, 0.002);
}

/// A town in which the road is seen or not, and tracking is lost on a straight or not.
std::vector<VehicleStep> Town(int seed, bool road, bool lost) {
  DriveErrors errors = kNoise;
  errors.per_100m = 0.01;
  errors.per_90deg = 0.005;
  errors.lever_arm = EvidenceOptions().turn_sigma;
  SyntheticSteps drive = MakeSteps(TownRoad(8, seed), kCar, 0.003, kUnit, errors, seed);
  if (road) ShowRoad(1.3, {.step = 0.01, .road = 0.005}, seed, drive);
  if (!lost) return drive.steps;
  const std::vector<TurningRegion> turns = FindTurns(drive.steps, {});
  LoseTracking(0.1, drive.steps[(turns[3].last + turns[4].first) / 2]);
  return drive.steps;
}

TEST(LiveScale, AgreesWithTheSmootherAtTheEndOfEachTurn) {
  for (int drive = 0; drive < 40; ++drive) {
    const int seed = drive / 4;
    const bool road = drive % 2 == 1;
    const std::vector<VehicleStep> steps = Town(seed, road, drive % 4 >= 2);
    LiveScale live(Prior(), {});
    int turns = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (live.Add(steps[i]) == TurnEnd::kNone) continue;
      ++turns;
      const std::vector<VehicleStep> so_far(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      const ScaleEstimateResult smoothed = EstimateScale(so_far, Prior(), {});
      ASSERT_TRUE(smoothed.estimate && live.Now());
      const ScaleBelief& last = smoothed.estimate->smoothed.back();
      const ScaleBelief& now = live.Now()->belief;
      EXPECT_NEAR(now.mean[kLogScale], last.mean[kLogScale], 0.2 * last.sigma()) << seed << ' ' << turns;
      // The smoother's grows with the scatter of the turns, which the filter does not look at.
      const double sigma = last.sigma() / smoothed.estimate->test.inflation;
      EXPECT_GT(now.sigma(), 0.95 * sigma);
      EXPECT_LT(now.sigma(), (road ? 1.12 : 1.03) * sigma);
    }
    EXPECT_EQ(turns, 8);
  }
}

TEST(LiveScale, DoesNotSeeTheFuture) {
  const std::vector<VehicleStep> steps = MakeSteps(TownRoad(5, 3), kCar, 0, kUnit, kNoise).steps;
  const std::vector<VehicleStep> start(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
  const auto whole = Live(steps);
  const auto half = Live(start);
  for (std::size_t i = 0; i < start.size(); ++i) {
    ASSERT_EQ(whole[i].has_value(), half[i].has_value());
    if (whole[i]) {
      EXPECT_EQ(whole[i]->mean, half[i]->mean);
    }
  }
}

// Wherever a turn begins, also where a long straight has just been put away.
TEST(LiveScale, ATurnLosesNoStepToTheStraightBeforeIt) {
  CarPrior prior = Prior();
  prior.yaw_sigma = 1e-6;  // which longer straights would tell better
  const auto drive = [&](int straight) {
    return Live(MakeSteps({{straight, 0, 5, 9}, {25, 3.6 * kDegree, 0.4, 5}, {5, 0, 5, 9}}, kCar, 0, kUnit).steps,
                prior);
  };
  const auto expected = drive(5);
  for (int straight = 30; straight < 130; ++straight) {
    const auto beliefs = drive(straight);
    for (int i = 0; i < 30; ++i) {
      const std::optional<ScaleBelief>& belief = beliefs[straight + i];
      ASSERT_EQ(belief.has_value(), expected[5 + i].has_value()) << straight << ' ' << i;
      if (!belief) continue;
      EXPECT_NEAR(belief->sigma(), expected[5 + i]->sigma(), 1e-9) << straight << ' ' << i;
      EXPECT_NEAR(belief->metres_per_unit() / kUnit, 1, 1e-4) << straight << ' ' << i;
    }
  }
}

// Steps that wait for a turn do not pile up: with all of them looked at again at each step, this would take many
// minutes.
TEST(LiveScale, StepsWithoutATurnDoNotPileUp) {
  LiveScale live(Prior(), {});
  for (const VehicleStep& step : MakeSteps(OneCorner(), kCar, 0, kUnit).steps) live.Add(step);
  const std::vector<VehicleStep> weave =
      MakeSteps({{30, 0, 5, 9}, {2, 2 * kDegree, 5, 9}, {2, -2 * kDegree, 5, 9}}, kCar, 0, kUnit).steps;
  for (int i = 0; i < 300000; ++i) live.Add(weave[i % weave.size()]);
  ASSERT_TRUE(live.Now());
  EXPECT_GT(live.Now()->belief.sigma(), 1) << "1500 km after its turn the scale is all but unknown";
}

}  // namespace
}  // namespace turnscale
