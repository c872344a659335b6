// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_evidence.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/scale/synthetic_steps.h"

namespace turnscale {
namespace {

constexpr double kHeight = 1.5;  // metres

DriveState StateOf(double metres_per_unit, double direction, const LeverArm& car) {
  DriveState state;
  state << std::log(metres_per_unit), direction, car.side_slip, 0, std::log(car.length), car.roll_height,
      std::log(kHeight), 0;
  return state;
}

PooledLine RandomTurn(Random& random) {
  return {.lever_arm = random.Uniform(0.05, 0.2),
          .sigma = random.Uniform(0.0001, 0.002),
          .by_direction = random.Uniform(-2, 2),
          .by_roll_height = random.Uniform(-0.1, 0.1),
          .mean_square_speed = random.Uniform(0, 1),
          .mean_speed = random.Uniform(0, 1)};
}

DriveState RandomState(Random& random) {
  const LeverArm car = {random.Uniform(0.5, 2.5), random.Uniform(0, 0.01), random.Uniform(0, 2)};
  const double direction = random.Uniform(-0.02, 0.02);
  DriveState state = StateOf(std::exp(random.Uniform(1, 3)), direction, car);
  state[kLag] = random.Uniform(-0.05, 0.05);
  return state;
}

std::vector<VehicleStep> Corner(const LeverArm& car, double direction, double side = 1) {
  return MakeSteps({{25, side * 3.5 * kDegree, 0.5, 6}}, car, direction, kUnit).steps;
}

/// A straight among two turns; what the straight says.
std::optional<StraightDirection> StraightBetweenTurns(const std::vector<StretchOfRoad>& straight, double direction,
                                                      const DriveErrors& errors = {}, std::uint64_t seed = 1) {
  std::vector<StretchOfRoad> road{{25, 3.5 * kDegree, 0.5, 6}};
  road.insert(road.end(), straight.begin(), straight.end());
  road.push_back({25, -3.5 * kDegree, 0.5, 6});
  const std::vector<VehicleStep> steps = MakeSteps(road, kCar, direction, kUnit, errors, seed).steps;
  const std::vector<PathSegment> segments = SplitIntoSegments(steps, {});
  EXPECT_EQ(segments.size(), 3u);
  return GatherEvidence(steps, segments, {}).at(1).straight;
}

/// `linearize` gives a measurement at a state.
template <typename Linearize>
void ExpectDerivatives(const DriveState& state, const Linearize& linearize) {
  constexpr double kSize = 1e-5;
  const Measurement measurement = linearize(state);
  for (int i = 0; i < kDriveUnknowns; ++i) {
    const DriveState off = kSize * DriveState::Unit(i);
    // What is expected grows by as much as the innovation falls.
    const double numeric = (linearize(state - off).innovation - linearize(state + off).innovation) / (2 * kSize);
    EXPECT_NEAR(measurement.by_state[i], numeric, 1e-6 * (1 + std::abs(numeric)));
  }
}

TEST(ScaleEvidence, DerivativesAgreeWithFiniteDifferences) {
  Random random(1);
  for (int draw = 0; draw < 200; ++draw) {
    const DriveState at = RandomState(random);
    const PooledLine turn = RandomTurn(random);
    ExpectDerivatives(at, [&](const DriveState& state) { return LinearizeTurn(turn, state, {}); });
    const DirectionInTurn in_turn{random.Uniform(-0.02, 0.02), 0.003, random.Uniform(-2, 2), random.Uniform(-2, 2)};
    ExpectDerivatives(at, [&](const DriveState& state) { return LinearizeDirectionInTurn(in_turn, state, {}); });
    const StraightDirection straight{.angle = random.Uniform(-0.1, 0.1), .sigma = 0.01};
    ExpectDerivatives(at, [&](const DriveState& state) { return LinearizeStraight(straight, state, {}); });
  }
}

TEST(ScaleEvidence, ListsWhatASegmentMeasuresInOrder) {
  Random random(4);
  const DriveState state = RandomState(random);
  const auto kinds = [&](const SegmentEvidence& evidence) {
    std::vector<MeasurementKind> listed;
    for (const SegmentMeasurement& measurement : MeasurementsOf(evidence, state, {}))
      listed.push_back(measurement.kind);
    return listed;
  };
  SegmentEvidence evidence;
  evidence.turn = RandomTurn(random);
  evidence.direction_in_turn = DirectionInTurn{0.01, 0.003, 0.5};
  evidence.road = RoadEvidence{.log_height = -2, .sigma = 0.01, .length = 3};
  const std::vector<SegmentMeasurement> all = MeasurementsOf(evidence, state, {});
  ASSERT_EQ(kinds(evidence), (std::vector{kRoadHeight, kDirectionInTurn, kLeverArmOfTurn}));
  EXPECT_EQ(all[0].linearized.innovation, LinearizeRoad(*evidence.road, state, {}).innovation);
  EXPECT_EQ(all[1].linearized.innovation, LinearizeDirectionInTurn(*evidence.direction_in_turn, state, {}).innovation);
  EXPECT_EQ(all[2].linearized.innovation, LinearizeTurn(*evidence.turn, state, {}).innovation);
  // Too fast.
  evidence.turn.reset();
  EXPECT_EQ(kinds(evidence), (std::vector{kRoadHeight, kDirectionInTurn}));
  SegmentEvidence straight;
  straight.straight = StraightDirection{.angle = 0, .sigma = 0.01};
  EXPECT_EQ(kinds(straight), (std::vector{kDirectionOfStraight}));
}

TEST(ScaleEvidence, ATurnOfTheModelMeetsItsExpectation) {
  for (const double side : {1.0, -1.0}) {
    for (const double direction : {0.0, 0.01, -0.01}) {
      const SegmentEvidence evidence = EvidenceOfTurn(Corner(kCar, direction, side), {});
      ASSERT_TRUE(evidence.turn) << evidence.why_no_turn;
      const DriveState truth = StateOf(kUnit, direction, kCar);
      EXPECT_NEAR(LinearizeTurn(*evidence.turn, truth, {}).innovation / evidence.turn->lever_arm, 0, 1e-9);
      EXPECT_NEAR(OwnScale(*evidence.turn, truth) / kUnit, 1, 1e-6);
      if (direction != 0) {
        EXPECT_GT(std::abs(OwnScale(*evidence.turn, StateOf(kUnit, 0, kCar)) / kUnit - 1), 0.02);
      }
    }
  }
}

TEST(ScaleEvidence, MeasuresALagWhereverTheCarTurns) {
  constexpr double kSeconds = 0.1;
  const DriveErrors lagging{.lag = kSeconds};
  DriveState truth = StateOf(kUnit, 0, kCar);
  truth[kLag] = kSeconds;
  std::vector<StretchOfRoad> turn;  // faster where the curvature is less
  for (const double share : {0.3, 0.6, 1.0, 0.6, 0.3}) turn.push_back({5, share * 4 * kDegree, 0.5, 7 - 3 * share});
  for (const double side : {1.0, -1.0}) {
    for (StretchOfRoad& stretch : turn) stretch.psi *= side;
    const SegmentEvidence evidence = EvidenceOfTurn(MakeSteps(turn, kCar, 0, kUnit, lagging).steps, {});
    ASSERT_TRUE(evidence.turn && evidence.direction_in_turn) << evidence.why_no_turn;
    EXPECT_NEAR(OwnScale(*evidence.turn, truth) / kUnit, 1, 2e-3);
    EXPECT_LT(OwnScale(*evidence.turn, StateOf(kUnit, 0, kCar)) / kUnit, 0.85);
    EXPECT_NEAR(LinearizeDirectionInTurn(*evidence.direction_in_turn, truth, {}).innovation, 0, 1e-3);
  }
  const StraightDirection bend = StraightBetweenTurns({{30, 0.8 * kDegree, 5, 9}}, 0, lagging).value();
  EXPECT_NEAR(LinearizeStraight(bend, truth, {}).innovation, 0, 1e-4);
}

TEST(ScaleEvidence, ATurnShowsTheDirectionOfTravelByItself) {
  // Faster where the curvature is less.
  std::vector<StretchOfRoad> bend;
  for (const double share : {0.3, 0.6, 1.0, 0.6, 0.3}) bend.push_back({5, share * 4 * kDegree, 0.5, 7 - 3 * share});
  for (const double direction : {0.01, -0.01}) {
    const SegmentEvidence evidence = EvidenceOfTurn(MakeSteps(bend, kCar, direction, kUnit).steps, {});
    ASSERT_TRUE(evidence.direction_in_turn) << evidence.why_no_turn;
    const DirectionInTurn& turn = *evidence.direction_in_turn;
    const Measurement measurement = LinearizeDirectionInTurn(turn, StateOf(kUnit, direction, kCar), {});
    EXPECT_NEAR(measurement.innovation, 0, 1e-4);
    EXPECT_EQ(measurement.by_state[kDirection], 1);
    EXPECT_GT(measurement.variance, std::pow(EvidenceOptions().direction_in_turn_sigma, 2));
    EXPECT_NEAR(LinearizeDirectionInTurn(turn, StateOf(kUnit, 0, kCar), {}).innovation, direction, 1e-4);
  }
  EXPECT_FALSE(EvidenceOfTurn(Corner(kCar, 0), {}).direction_in_turn) << "a turn of even curvature";
}

TEST(ScaleEvidence, OwnScaleIsWhereTheInnovationVanishes) {
  Random random(2);
  for (int draw = 0; draw < 200; ++draw) {
    const PooledLine turn = RandomTurn(random);
    DriveState state = RandomState(random);
    state[kLogScale] = std::log(OwnScale(turn, state));
    ASSERT_TRUE(std::isfinite(state[kLogScale]));
    EXPECT_NEAR(LinearizeTurn(turn, state, {}).innovation, 0, 1e-12);
  }
}

// The effective lever arm of turns that differ from the model by what the options say.
TEST(ScaleEvidence, VarianceIsThatOfTurnsThatDifferAsStated) {
  const EvidenceOptions options;
  const DriveErrors errors{.direction = 0.25 * kDegree,
                           .lever_arm = options.turn_sigma,
                           .slip = options.slip_sigma,
                           .turn_direction = options.turn_direction_sigma};
  const DriveState truth = StateOf(kUnit, 0, kCar);
  for (const double speed : {3.0, 10.0}) {
    double squares = 0;
    double variance = 0;
    constexpr int kDraws = 2000;
    for (int seed = 0; seed < kDraws; ++seed) {
      const std::vector<StretchOfRoad> corner{{25, 3.5 * kDegree, 0.5, speed}};
      const SegmentEvidence evidence = EvidenceOfTurn(MakeSteps(corner, kCar, 0, kUnit, errors, seed).steps, options);
      const Measurement measurement = LinearizeTurn(evidence.turn.value(), truth, options);
      squares += measurement.innovation * measurement.innovation;
      variance += measurement.variance;
    }
    EXPECT_NEAR(std::sqrt(variance / squares), 1, 0.045) << speed << " m/s";
  }
}

TEST(ScaleEvidence, AStraightShowsTheDirectionOfTravel) {
  for (const double direction : {0.0, 0.012, -0.02}) {
    const StraightDirection straight = StraightBetweenTurns({{30, 0, 5, 10}}, direction).value();
    EXPECT_NEAR(straight.angle, direction, 1e-6);
    EXPECT_GT(straight.sigma, 0);
    EXPECT_LT(straight.sigma, 0.001);
    const Measurement measurement = LinearizeStraight(straight, StateOf(kUnit, 0.005, kCar), {});
    EXPECT_NEAR(measurement.innovation, direction - 0.005, 1e-6);
    EXPECT_EQ(measurement.by_state[kLogScale], 0) << "straights are not asked for the scale";
  }
}

TEST(ScaleEvidence, BendsOfAStraightAreTakenOut) {
  const std::vector<StretchOfRoad> bends{{10, 1 * kDegree, 5, 9}, {10, -1 * kDegree, 5, 9}, {10, 0, 5, 9}};
  const StraightDirection even = StraightBetweenTurns(bends, 0.01).value();
  EXPECT_NEAR(even.angle, 0.01, 3e-6);
  // A bend to one side: known as far as the lever arm that acts in it is.
  const StraightDirection bend = StraightBetweenTurns({{30, 0.8 * kDegree, 5, 9}}, 0.01).value();
  EXPECT_NEAR(bend.angle, 0.01, 1.1e-4);
  EXPECT_GT(bend.sigma, 1.5 * even.sigma);
  const double swing = kCar.At(9) * 0.8 * kDegree / 5;
  EXPECT_LT(std::abs(bend.angle - 0.01), 0.08 * swing) << "most of the bend is gone";
}

// At motorway speed, slip turns the sign of the effective lever arm.
TEST(ScaleEvidence, SlipInFastBendsIsNotTakenForTheDirectionOfTravel) {
  constexpr double kDirection = 0.002;
  constexpr double kBend = 1 * kDegree;  // in 17 m: 970 m of radius
  const StraightDirection bend = StraightBetweenTurns({{30, kBend, 17, 28}}, kDirection).value();
  const double slip = kCar.side_slip * 28 * 28 * kBend / 17;
  EXPECT_GT(slip, 0.004);
  const Measurement measurement = LinearizeStraight(bend, StateOf(kUnit, kDirection, kCar), {});
  EXPECT_NEAR(measurement.innovation, 0, 5e-5);
  const Measurement even = LinearizeStraight(StraightBetweenTurns({{30, 0, 17, 28}}, kDirection).value(),
                                             StateOf(kUnit, kDirection, kCar), {});
  EXPECT_GT(measurement.variance - even.variance, std::pow(0.3 * slip, 2)) << "roads are banked";
  // Neither the scale nor the slip comes from straights.
  EXPECT_EQ(measurement.by_state[kLogScale], 0);
  EXPECT_EQ(measurement.by_state[kSlip], 0);
  EXPECT_EQ(measurement.by_state[kLogLeverArm], 0);
}

TEST(ScaleEvidence, DirectionOfStraightsScattersAsItsSigmaSays) {
  double squares = 0;
  double variance = 0;
  constexpr int kDraws = 300;
  for (int seed = 0; seed < kDraws; ++seed) {
    const StraightDirection straight =
        StraightBetweenTurns({{30, 0, 5, 10}}, 0.005, {.direction = 0.4 * kDegree}, seed).value();
    squares += std::pow(straight.angle - 0.005, 2);
    variance += std::pow(straight.sigma, 2);
  }
  EXPECT_NEAR(std::sqrt(variance / squares), 1, 0.1);
}

TEST(ScaleEvidence, AStraightOfTwoStepsShowsNothing) { EXPECT_FALSE(StraightBetweenTurns({{2, 0, 5, 10}}, 0.01)); }

TEST(ScaleEvidence, WhatIsNotUsableShowsNoDirection) {
  std::vector<VehicleStep> steps = MakeSteps({{30, 0, 5, 10}}, kCar, 0.01, kUnit).steps;
  for (std::size_t i = 0; i < steps.size(); i += 2) {
    steps[i].usable = false;
    steps[i].motion.theta = 1;
  }
  const PathSegment whole{.first = 0, .last = 29};
  EXPECT_NEAR(GatherEvidence(steps, {whole}, {})[0].straight.value().angle, 0.01, 1e-6);
  for (VehicleStep& step : steps) step.usable = false;
  EXPECT_FALSE(GatherEvidence(steps, {whole}, {})[0].straight);
}

TEST(ScaleEvidence, ATurnWithoutALineSaysWhy) {
  std::vector<VehicleStep> steps = Corner(kCar, 0);
  for (VehicleStep& step : steps) step.motion.step = 0;
  const SegmentEvidence evidence = EvidenceOfTurn(steps, {});
  EXPECT_FALSE(evidence.turn);
  EXPECT_FALSE(evidence.why_no_turn.empty());
  EXPECT_TRUE(MeasurementsOf(evidence, StateOf(kUnit, 0, kCar), {}).empty());
}

TEST(ScaleEvidence, EveryTurnIsItsOwn) {
  const std::vector<StretchOfRoad> road{
      {10, 0, 5, 10}, {25, 3.5 * kDegree, 0.5, 6}, {50, 0, 5, 10}, {30, -3 * kDegree, 0.4, 4}};
  const std::vector<VehicleStep> steps = MakeSteps(road, kCar, 0.01, kUnit).steps;
  const std::vector<PathSegment> segments = SplitIntoSegments(steps, {});
  const std::vector<SegmentEvidence> evidence = GatherEvidence(steps, segments, {});
  ASSERT_EQ(evidence.size(), segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    EXPECT_EQ(evidence[i].turn.has_value(), segments[i].turning);
    EXPECT_EQ(evidence[i].straight.has_value(), !segments[i].turning);
    if (!segments[i].turning) continue;
    const auto alone = EvidenceOfTurn(StepsOf(steps, segments[i].first, segments[i].last), {});
    EXPECT_EQ(evidence[i].turn->lever_arm, alone.turn->lever_arm);
  }
}

TEST(RoadEvidence, IsTheRobustMeanOfTheSteps) {
  SyntheticSteps drive = MakeSteps({{40, 0, 6, 10}}, kCar, 0, kUnit);
  ShowRoad(kHeight, {}, 1, drive);
  drive.steps[7].height *= 3;
  drive.steps[8].height *= 0.4;
  drive.steps[20].height = 0;
  const auto road = EvidenceOfRoad(drive.steps, {});
  ASSERT_TRUE(road);
  EXPECT_NEAR(road->log_height, std::log(kHeight / kUnit), 0.003);
  EXPECT_NEAR(road->length * kUnit, 39 * 6, 1e-9);
  EXPECT_NEAR(road->sigma, RoadEvidenceOptions{}.step_sigma / std::sqrt(39), 3e-4);
}

TEST(RoadEvidence, NeedsSomeSteps) {
  SyntheticSteps drive = MakeSteps({{40, 0, 6, 10}}, kCar, 0, kUnit);
  EXPECT_FALSE(EvidenceOfRoad(drive.steps, {}));
  drive.steps[3].height = 0.1;
  EXPECT_FALSE(EvidenceOfRoad(drive.steps, {}));
  drive.steps[4].height = 0.1;
  EXPECT_TRUE(EvidenceOfRoad(drive.steps, {}));
}

TEST(RoadEvidence, MeasuresHeightOverScale) {
  DriveState state = StateOf(kUnit, 0, kCar);
  state[kRoadError] = 0.7;
  RoadEvidence road{.log_height = std::log(kHeight / kUnit) + 0.01, .sigma = 0.002, .length = 1e-6};
  const RoadEvidenceOptions options;
  const Measurement near = LinearizeRoad(road, state, options);
  EXPECT_NEAR(near.innovation, 0.01 - 0.7 * options.sigma, 1e-6);
  EXPECT_NEAR(near.by_state[kRoadError], options.sigma, 1e-6);
  EXPECT_EQ(near.by_state[kLogScale], -1);
  EXPECT_EQ(near.by_state[kLogHeight], 1);
  EXPECT_NEAR(near.variance, 4e-6, 1e-12);
  // Along a long way the error averages out: over n lengths to sqrt(2/n).
  road.length = 100 * options.correlation_length / kUnit;
  EXPECT_NEAR(LinearizeRoad(road, state, options).by_state[kRoadError] / options.sigma, std::sqrt(0.02), 1e-3);
}

TEST(EvidenceOptions, RefusesSenselessValues) {
  const auto refused = [](auto change) { return RefusedField<EvidenceOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.turn_sigma = 0; }), "evidence.turn_sigma");
  EXPECT_EQ(refused([](auto& o) { o.slip_sigma = -1; }), "evidence.slip_sigma");
  EXPECT_EQ(refused([](auto& o) { o.turn_direction_sigma = -1; }), "evidence.turn_direction_sigma_deg");
  EXPECT_EQ(refused([](auto& o) { o.direction_in_turn_sigma = 0; }), "evidence.direction_in_turn_sigma_deg");
  EXPECT_EQ(refused([](auto& o) { o.straight_direction_sigma = 0; }), "evidence.straight_direction_sigma_deg");
  EXPECT_EQ(refused([](auto& o) { o.min_lever_arm_ratio = 1; }), "evidence.min_lever_arm_ratio");
  EXPECT_EQ(refused([](auto& o) { o.line.min_inliers = 0; }), "line.min_inliers");
  EXPECT_EQ(refused([](auto& o) { o.road.sigma = 0; }), "evidence.road_sigma");
  EXPECT_EQ(refused([](auto& o) { o.road.correlation_length = 0; }), "evidence.road_correlation_length");
  EXPECT_EQ(refused([](auto& o) { o.road.step_sigma = 1; }), "evidence.road_step_sigma");
  EXPECT_EQ(refused([](auto& o) { o.road.min_steps = 0; }), "evidence.road_min_steps");
}

TEST(CarPrior, RefusesSenselessValues) {
  const auto refused = [](auto change) {
    return RefusedField<CarPrior>([&](CarPrior& car) {
      car.lever_arm = 1;
      change(car);
    });
  };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& c) { c.lever_arm = 0; }), "car.lever_arm");
  EXPECT_EQ(refused([](auto& c) { c.lever_arm = std::nan(""); }), "car.lever_arm");
  EXPECT_EQ(refused([](auto& c) { c.lever_arm = 145; }), "car.lever_arm") << "centimetres";
  EXPECT_EQ(refused([](auto& c) { c.camera_height = 150; }), "car.camera_height");
  EXPECT_EQ(refused([](auto& c) { c.lever_arm_sigma = 1; }), "car.lever_arm_sigma");
  EXPECT_EQ(refused([](auto& c) { c.lever_arm_sigma = TapeSigma(c.lever_arm = 0.02); }), "");
  EXPECT_EQ(refused([](auto& c) { c.lever_arm_sigma = -0.1; }), "car.lever_arm_sigma");
  EXPECT_EQ(refused([](auto& c) { c.side_slip = -0.001; }), "car.side_slip");
  EXPECT_EQ(refused([](auto& c) { c.side_slip_sigma = -1; }), "car.side_slip_sigma");
  EXPECT_EQ(refused([](auto& c) { c.yaw_sigma = 0; }), "car.yaw_sigma");
  EXPECT_EQ(refused([](auto& c) { c.image_lag_sigma = -1; }), "car.image_lag_sigma");
  EXPECT_EQ(refused([](auto& c) { c.image_lag = 0.1; }), "car.image_lag");
  EXPECT_EQ(refused([](auto& c) { c.roll_height = -1; }), "car.roll_height");
  EXPECT_EQ(refused([](auto& c) { c.roll_height_sigma = 10; }), "car.roll_height_sigma");
  EXPECT_EQ(refused([](auto& c) { c.camera_height = -1; }), "car.camera_height");
  EXPECT_EQ(refused([](auto& c) {
              c.camera_height = 1;
              c.camera_height_sigma = 1;
            }),
            "car.camera_height_sigma");
  EXPECT_EQ(refused([](auto& c) {
              c.lever_arm = 0;
              c.camera_height = 1.5;
            }),
            "")
      << "a height alone will do";
}

}  // namespace
}  // namespace turnscale
