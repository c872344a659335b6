// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/pooled_line.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/synthetic_drive.h"

namespace turnscale {
namespace {

const LeverArm kRigid{1.2, 0};
const LeverArm kSlipping{1.2, 0.005};
constexpr double kMetresPerUnit = 7.0;
constexpr int kSteps = 20;
constexpr int kSeeds = 200;

/// A corner of 90 degrees in units of 7 m, from step to step at the metres of `distance`, a function of 0...1.
template <typename Distance>
std::vector<VehicleStep> CornerAt(const LeverArm& lever_arm, double side, Distance distance) {
  std::vector<VehicleStep> corner;
  for (int i = 0; i < kSteps; ++i) {
    const double middle = std::sin(M_PI * (i + 0.5) / kSteps);
    const DriveSegment segment{1, distance(middle), side * middle * M_PI * M_PI / (4.0 * kSteps)};
    const Eigen::Quaterniond identity = Eigen::Quaterniond::Identity();
    TurningMotion motion = TurningMotionOf(SlippingCameraMotion(segment, kStepInterval, lever_arm, identity), identity);
    motion.step /= kMetresPerUnit;
    corner.push_back({.motion = motion, .duration = kStepInterval, .first = i, .last = i + 1});
  }
  return corner;
}

/// Taken while braking and speeding up again.
std::vector<VehicleStep> Corner(const LeverArm& lever_arm, double side = 1) {
  return CornerAt(lever_arm, side, [](double middle) { return 1.0 - 0.5 * middle; });
}

/// Taken at 7 m/s.
std::vector<VehicleStep> EvenCorner(const LeverArm& lever_arm) {
  return CornerAt(lever_arm, 1, [](double) { return 0.7; });
}

/// The same way backwards: each step seen from its end.
std::vector<VehicleStep> Reversed(std::vector<VehicleStep> steps) {
  for (VehicleStep& step : steps) {
    step.motion.theta = M_PI + step.motion.theta - step.motion.psi;
    step.motion.psi *= -1;
  }
  return steps;
}

/// Moves the camera sideways by normal noise of `sigma` units in each step.
void AddSidewaysNoise(double sigma, unsigned seed, std::vector<VehicleStep>& steps) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  for (VehicleStep& step : steps) {
    const double sideways = step.motion.step * std::sin(step.motion.theta) + normal(random);
    const double forward = step.motion.step * std::cos(step.motion.theta);
    step.motion.theta = std::atan2(sideways, forward);
    step.motion.step = std::hypot(sideways, forward);
  }
}

/// Lets the body lean outwards with the lateral acceleration, `lag` steps late, and take the camera with it, which is
/// `height` metres above the axis of the roll.
void AddRoll(double height, double lag, std::vector<VehicleStep>& steps) {
  constexpr double kRollPerTurn = 0.3;  // rad per rad of turning in a step
  const auto lean = [&](double at) {
    const double middle = (at - lag + 0.5) / kSteps;
    return middle > 0 && middle < 1 ? -kRollPerTurn * std::sin(M_PI * middle) * steps[kSteps / 2].motion.psi : 0.0;
  };
  for (int i = 0; i < kSteps; ++i) {
    TurningMotion& motion = steps[i].motion;
    steps[i].roll = lean(i + 0.5) - lean(i - 0.5);
    const double middle = motion.theta - 0.5 * motion.psi;
    const double sideways = motion.step * std::sin(middle) + height / kMetresPerUnit * steps[i].roll;
    const double forward = motion.step * std::cos(middle);
    motion.theta = std::atan2(sideways, forward) + 0.5 * motion.psi;
    motion.step = std::hypot(sideways, forward);
  }
}

PooledLine LineOf(const std::vector<VehicleStep>& steps, const PooledLineOptions& options = {}) {
  const PooledLineResult result = PoolTurn(steps, options);
  EXPECT_TRUE(result.line) << result.reason;
  return result.line.value_or(PooledLine{});
}

double Scale(const std::vector<VehicleStep>& steps, const LeverArm& lever_arm) {
  return MetresPerUnit(LineOf(steps), lever_arm);
}

double MedianScaleOf(const std::vector<VehicleStep>& steps, const LeverArm& lever_arm) {
  return MedianOfSteps(steps, lever_arm).metres_per_unit;
}

TEST(PooledLine, ExactWithoutNoiseRigidAndSlipping) {
  for (const LeverArm& lever_arm : {kRigid, kSlipping}) {
    EXPECT_NEAR(Scale(EvenCorner(lever_arm), lever_arm) / kMetresPerUnit, 1.0, 1e-12);
    EXPECT_NEAR(MedianScaleOf(Corner(lever_arm), lever_arm) / kMetresPerUnit, 1.0, 1e-12);
  }
  EXPECT_NEAR(Scale(Corner(kRigid), kRigid) / kMetresPerUnit, 1.0, 1e-12);
  EXPECT_NEAR(Scale(Corner(kSlipping), kSlipping) / kMetresPerUnit, 1.0, 1e-4) << "one slope for all speeds of a turn";
  EXPECT_GT(Scale(Corner(kSlipping), kRigid), 1.1 * kMetresPerUnit) << "the slip is worth modelling here";
}

TEST(PooledLine, DescribesTheTurn) {
  const PooledLine rigid = LineOf(Corner(kRigid));
  EXPECT_NEAR(rigid.lever_arm * kMetresPerUnit, kRigid.length, 1e-12);
  EXPECT_EQ(rigid.steps, kSteps);
  EXPECT_EQ(rigid.inliers, kSteps);
  EXPECT_NEAR(rigid.angle, M_PI / 2, 0.002);
  EXPECT_NEAR(LineOf(Corner(kRigid, -1)).angle, -rigid.angle, 1e-15);

  const PooledLine even = LineOf(EvenCorner(kSlipping));
  EXPECT_NEAR(std::sqrt(even.mean_square_speed) * kMetresPerUnit, 7.0, 1e-12);
  EXPECT_NEAR(even.lever_arm * kMetresPerUnit, 1.2 - 0.005 * 49, 1e-12);
  EXPECT_NEAR(LeverArmRatio(even, kSlipping, kMetresPerUnit), (1.2 - 0.005 * 49) / 1.2, 1e-12);
  EXPECT_EQ(LeverArmRatio(even, kRigid, kMetresPerUnit), 1);

  const PooledLine braking = LineOf(Corner(kSlipping));
  EXPECT_LT(braking.lever_arm * kMetresPerUnit, kSlipping.At(5.0));
  EXPECT_GT(braking.lever_arm * kMetresPerUnit, kSlipping.At(7.0));
}

TEST(PooledLine, LeverArmRatioIsNegativeWhereTheRearSlidesOutAhead) {
  const PooledLine line{.lever_arm = 0.1, .mean_square_speed = 4};
  EXPECT_GT(LeverArmRatio(line, kSlipping, std::sqrt(1.2 / 0.005) / 2 * 0.99), 0);
  EXPECT_LT(LeverArmRatio(line, kSlipping, std::sqrt(1.2 / 0.005) / 2 * 1.01), 0);
}

TEST(PooledLine, ScaleIsWhereTheTurnShowsTheLeverArm) {
  std::mt19937 random(41);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 500; ++i) {
    const LeverArm car{0.5 + 2 * uniform(random), 0.01 * uniform(random)};
    const double scale = std::exp(6 * uniform(random) - 3);
    const double direction = 0.01 * (uniform(random) - 0.5);
    // Some of these cars slide so much that the camera swings inwards.
    const double speed = 25 * uniform(random);
    PooledLine line;
    line.mean_square_speed = speed * speed / (scale * scale);
    line.by_direction = 30 * (uniform(random) - 0.5) / scale;
    line.lever_arm = car.At(speed) / scale + direction * line.by_direction;
    EXPECT_NEAR(MetresPerUnit(line, car, direction) / scale, 1, 1e-9);
  }
}

TEST(PooledLine, RollOfTheBodyIsAllowedFor) {
  const double height = 1.1;
  for (const double side : {1.0, -1.0}) {
    for (const double lag : {-2.0, 2.0}) {
      std::vector<VehicleStep> steps = Corner(kRigid, side);
      const PooledLine upright = LineOf(steps);
      AddRoll(height, lag, steps);
      const PooledLine line = LineOf(steps);
      EXPECT_NEAR(MetresPerUnit(line, {1.2, 0, height}) / kMetresPerUnit, 1, 1e-3);
      EXPECT_GT(std::abs(MetresPerUnit(line, kRigid) / kMetresPerUnit - 1), 0.01) << "it is worth allowing for";
      EXPECT_LT(line.sigma, 1.1 * upright.sigma) << "it is no noise";
    }
  }
}

TEST(PooledLine, ADirectionThatIsOffIsAllowedFor) {
  for (const double side : {1.0, -1.0}) {
    for (const double direction : {0.01, -0.02}) {
      std::vector<VehicleStep> steps = Corner(kRigid, side);
      for (VehicleStep& step : steps) step.motion.theta += direction;
      const PooledLine line = LineOf(steps);
      EXPECT_NEAR(MetresPerUnit(line, kRigid, direction) / kMetresPerUnit, 1, 0.0005);
      EXPECT_GT(std::abs(MetresPerUnit(line, kRigid) / kMetresPerUnit - 1), 0.03) << "it is worth allowing for";
    }
  }
}

TEST(PooledLine, GrowsWithTheDirectionAsItSays) {
  const std::vector<VehicleStep> corner = Corner(kSlipping);
  const auto turned = [&](double direction) {
    std::vector<VehicleStep> steps = corner;
    for (VehicleStep& step : steps) step.motion.theta += direction;
    return LineOf(steps).lever_arm;
  };
  constexpr double kSmall = 1e-5;
  // It leaves out the cosine of the direction of travel as seen half-way, which is near 1.
  EXPECT_NEAR((turned(kSmall) - turned(-kSmall)) / (2 * kSmall) / LineOf(corner).by_direction, 1, 0.01);
}

TEST(PooledLine, ShowsTheDirectionOfTravel) {
  for (const double side : {1.0, -1.0}) {
    for (const double direction : {0.01, -0.02}) {
      for (const LeverArm& lever_arm : {kRigid, kSlipping}) {
        std::vector<VehicleStep> steps = Corner(lever_arm, side);
        AddRoll(0.6, 2, steps);
        for (VehicleStep& step : steps) step.motion.theta += direction;
        const std::optional<DirectionInTurn> shown = FitDirectionInTurn(steps, {});
        ASSERT_TRUE(shown);
        EXPECT_NEAR(shown->angle + lever_arm.side_slip * kMetresPerUnit * shown->by_slip, direction,
                    0.02 * std::abs(direction));
        EXPECT_GT(shown->sigma, 0.001) << "steps are never better than that";
        EXPECT_LT(shown->sigma, 0.004);
      }
    }
  }
}

TEST(PooledLine, TheDirectionScattersAsItsSigmaSaysAndIndependentlyOfTheLine) {
  double squares = 0;
  double sigma = 0;
  double product = 0;
  double line_squares = 0;
  const double lever_arm = LineOf(EvenCorner(kRigid)).lever_arm;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    std::vector<VehicleStep> steps = EvenCorner(kRigid);
    AddSidewaysNoise(0.0015, seed, steps);
    const PooledLine line = LineOf(steps);
    const std::optional<DirectionInTurn> shown = FitDirectionInTurn(steps, {});
    ASSERT_TRUE(shown);
    squares += std::pow(shown->angle, 2);
    sigma += shown->sigma;
    product += shown->angle * (line.lever_arm - lever_arm);
    line_squares += std::pow(line.lever_arm - lever_arm, 2);
  }
  EXPECT_NEAR(sigma / kSeeds / std::sqrt(squares / kSeeds), 1.0, 0.2);
  EXPECT_LT(std::abs(product) / std::sqrt(squares * line_squares), 0.2);
}

TEST(PooledLine, ATurnOfEvenCurvatureShowsNoDirection) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::vector<VehicleStep> steps(4 * kSteps, EvenCorner(kRigid)[kSteps / 2]);
    std::mt19937 random(seed);
    std::normal_distribution<double> psi(0, 0.05 * M_PI / 180);
    for (VehicleStep& step : steps) step.motion.psi += psi(random);
    EXPECT_FALSE(FitDirectionInTurn(steps, {}));
  }
}

TEST(PooledLine, TheDirectionIsUncertainWhereTheCurvatureHardlyChanges) {
  double sum = 0;
  double sigma = 0;
  constexpr int kRuns = 20;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    std::vector<VehicleStep> steps(4 * kSteps, EvenCorner(kRigid)[kSteps / 2]);
    std::mt19937 random(seed);
    std::normal_distribution<double> psi(0, 0.05 * M_PI / 180);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      // The noise of psi enters the lateral displacement of the step, too.
      const double share = 1 + 0.1 * std::sin(0.3 * static_cast<double>(i));
      const double sideways = steps[i].motion.step * std::sin(steps[i].motion.theta - 0.5 * steps[i].motion.psi);
      steps[i].motion.psi *= share;
      steps[i].motion.theta = 0.5 * steps[i].motion.psi + std::asin(share * sideways / steps[i].motion.step);
      steps[i].motion.psi += psi(random);
    }
    const std::optional<DirectionInTurn> shown = FitDirectionInTurn(steps, {});
    ASSERT_TRUE(shown);
    sum += shown->angle;
    sigma += shown->sigma;
  }
  EXPECT_LT(std::abs(sum), 2 * sigma) << "a bias that is the same in all such turns";
}

TEST(PooledLine, LeftAndRightAreMirrorImages) {
  std::vector<VehicleStep> right = Corner(kSlipping);
  AddSidewaysNoise(0.001, 5, right);
  std::vector<VehicleStep> left = right;
  for (VehicleStep& step : left) {
    step.motion.psi *= -1;
    step.motion.theta *= -1;
  }
  const PooledLine a = LineOf(right);
  const PooledLine b = LineOf(left);
  EXPECT_EQ(a.lever_arm, b.lever_arm);
  EXPECT_EQ(a.sigma, b.sigma);
  EXPECT_EQ(a.by_direction, -b.by_direction);
  EXPECT_EQ(MedianOfSteps(right, kSlipping).metres_per_unit, MedianOfSteps(left, kSlipping).metres_per_unit);
  EXPECT_NEAR(Scale(Corner(kRigid, -1), kRigid) / kMetresPerUnit, 1.0, 1e-12);
}

TEST(PooledLine, HoldsInReverse) {
  std::vector<VehicleStep> steps = Reversed(Corner(kRigid));
  EXPECT_NEAR(Scale(steps, kRigid) / kMetresPerUnit, 1.0, 1e-12);
}

// The tyres slip outwards in reverse as well, which there adds to the swing of a camera ahead of them.
TEST(PooledLine, SlipInReverseLengthensTheLeverArm) {
  const LeverArm acting{kSlipping.length + kSlipping.side_slip * 49};
  const std::vector<VehicleStep> steps = Reversed(EvenCorner(acting));
  EXPECT_NEAR(Scale(steps, kSlipping) / kMetresPerUnit, 1.0, 1e-12);
  EXPECT_LT(LineOf(steps).mean_square_speed, 0);
  EXPECT_GT(LeverArmRatio(LineOf(steps), kSlipping, kMetresPerUnit), 1);
  EXPECT_NEAR(MedianScaleOf(steps, kSlipping) / kMetresPerUnit, 1.0, 1e-12);
}

TEST(PooledLine, TooLittleSwingInReverseHasNoScale) {
  PooledLine line{.mean_square_speed = -0.04};
  const double least = 2 * std::sqrt(kSlipping.side_slip * 0.04 * kSlipping.length);
  line.lever_arm = 0.99 * least;
  EXPECT_TRUE(std::isinf(MetresPerUnit(line, kSlipping)));
  line.lever_arm = 1.01 * least;
  EXPECT_LT(std::pow(MetresPerUnit(line, kSlipping), 2) * kSlipping.side_slip * 0.04, kSlipping.length) << "slow root";
}

TEST(PooledLine, TheObserverOfAStepAgreesInReverse) {
  const LeverArm acting{kSlipping.length + kSlipping.side_slip * 49};
  for (const VehicleStep& step : Reversed(EvenCorner(acting))) {
    const double metres = ObservedDistance(step.motion.psi, step.motion.theta, step.duration, kSlipping);
    EXPECT_NEAR(metres / step.motion.step / kMetresPerUnit, 1.0, 1e-9);
  }
}

TEST(PooledLine, UnitOfLengthCancels) {
  std::vector<VehicleStep> steps = Corner(kSlipping);
  AddSidewaysNoise(0.002, 6, steps);
  const PooledLine before = LineOf(steps);
  const MedianScale median = MedianOfSteps(steps, kSlipping);
  for (const double k : {1e-3, 0.1, 3.0, 1e4}) {
    std::vector<VehicleStep> scaled = steps;
    for (VehicleStep& step : scaled) step.motion.step *= k;
    const PooledLine after = LineOf(scaled);
    EXPECT_NEAR(MetresPerUnit(after, kSlipping, 0.01) * k / MetresPerUnit(before, kSlipping, 0.01), 1.0, 1e-12);
    EXPECT_NEAR(after.sigma / (k * before.sigma), 1.0, 1e-9);
    EXPECT_EQ(after.inliers, before.inliers);
    EXPECT_NEAR(MedianOfSteps(scaled, kSlipping).metres_per_unit * k / median.metres_per_unit, 1.0, 1e-12);
    EXPECT_NEAR(MedianOfSteps(scaled, kSlipping).spread / median.spread, 1.0, 1e-9);
  }
}

TEST(PooledLine, SpreadAgreesWithSigma) {
  for (const LeverArm& lever_arm : {kRigid, kSlipping}) {
    double sum = 0;
    double squares = 0;
    double sigma = 0;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      std::vector<VehicleStep> steps = EvenCorner(lever_arm);
      AddSidewaysNoise(0.0015, seed, steps);
      const PooledLine line = LineOf(steps);
      sum += line.lever_arm;
      squares += line.lever_arm * line.lever_arm;
      sigma += line.sigma;
    }
    const double mean = sum / kSeeds;
    const double spread = std::sqrt(squares / kSeeds - mean * mean);
    EXPECT_NEAR(sigma / kSeeds / spread, 1.0, 0.2);
    EXPECT_LT(std::abs(mean * kMetresPerUnit - lever_arm.At(7)), 3 * spread * kMetresPerUnit / std::sqrt(kSeeds));
  }
}

TEST(PooledLine, FewerStepsThanTheNoiseAsksForAreNotBelieved) {
  const PooledLine line = LineOf(Corner(kRigid));
  PooledLineOptions options;
  options.sigma_theta *= 2;
  EXPECT_GT(line.sigma, 0);
  EXPECT_NEAR(LineOf(Corner(kRigid), options).sigma / line.sigma, 2, 1e-9);
}

TEST(PooledLine, PoolingBeatsThePerFrameObserver) {
  double pooled = 0;
  double per_frame = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::vector<VehicleStep> steps = Corner(kRigid);
    AddSidewaysNoise(0.003, seed, steps);
    pooled += std::pow(Scale(steps, kRigid) - kMetresPerUnit, 2);
    per_frame += std::pow(MedianScaleOf(steps, kRigid) - kMetresPerUnit, 2);
  }
  EXPECT_LT(pooled, 0.8 * per_frame);
}

TEST(PooledLine, GrossOutliersHaveNoSay) {
  std::vector<VehicleStep> steps = Corner(kSlipping);
  AddSidewaysNoise(0.001, 7, steps);
  const double clean = Scale(steps, kSlipping);
  for (const double theta : {-1.0, 1.0, -2.0}) {
    std::vector<VehicleStep> spoilt = steps;
    spoilt[9].motion.theta = theta;
    spoilt[10].motion.theta = theta;
    const PooledLine line = LineOf(spoilt);
    EXPECT_NEAR(MetresPerUnit(line, kSlipping) / clean, 1.0, 0.01);
    EXPECT_EQ(line.inliers, 18);
  }
}

TEST(PooledLine, WhatIsNotUsableIsLeftOut) {
  std::vector<VehicleStep> steps = Corner(kRigid);
  for (const std::size_t i : {4, 8, 9, 15}) {
    steps[i].motion.theta = 3;
    steps[i].usable = false;
  }
  const PooledLine line = LineOf(steps);
  EXPECT_EQ(line.steps, kSteps - 4);
  EXPECT_NEAR(MetresPerUnit(line, kRigid) / kMetresPerUnit, 1, 1e-12);
  EXPECT_NEAR(MedianScaleOf(steps, kRigid) / kMetresPerUnit, 1, 1e-12);
}

TEST(PooledLine, FewExactStepsDoNotThrowOutAGoodOne) {
  const std::vector<VehicleStep> corner = Corner(kRigid);
  std::vector<VehicleStep> steps(corner.begin() + 8, corner.begin() + 12);
  steps[1].motion.theta += 0.004;
  const PooledLine line = LineOf(steps);
  EXPECT_EQ(line.inliers, 4);
  EXPECT_GT(line.sigma, 0.005 * line.lever_arm) << "four steps are not believed to be without noise";
}

TEST(PooledLine, ACameraThatSwingsInwardsHasNoScaleUnlessTheTyresSlip) {
  std::vector<VehicleStep> inwards = Corner(kRigid);
  for (VehicleStep& step : inwards) step.motion.theta = step.motion.psi - step.motion.theta;
  const PooledLine line = LineOf(inwards);
  EXPECT_LT(line.lever_arm, 0);
  EXPECT_EQ(MetresPerUnit(line, kRigid), std::numeric_limits<double>::infinity());
  EXPECT_EQ(MedianScaleOf(inwards, kRigid), std::numeric_limits<double>::infinity());
  const double with_slip = MetresPerUnit(line, kSlipping);
  EXPECT_LT(LeverArmRatio(line, kSlipping, with_slip), 0) << "slip alone explains it";
  const PooledLine nothing{};
  EXPECT_EQ(MetresPerUnit(nothing, kRigid), std::numeric_limits<double>::infinity());
}

TEST(PooledLine, SaysWhyThereIsNone) {
  const auto reason = [](const std::vector<VehicleStep>& steps) {
    const PooledLineResult result = PoolTurn(steps, {});
    EXPECT_FALSE(result.line);
    return result.reason;
  };
  EXPECT_EQ(reason({}), "no steps");

  std::vector<VehicleStep> unusable = Corner(kRigid);
  for (VehicleStep& step : unusable) step.usable = false;
  EXPECT_EQ(reason(unusable), "no steps");

  std::vector<VehicleStep> bend = Corner(kRigid);
  bend.resize(3);
  EXPECT_NE(reason(bend).find("deg"), std::string::npos);

  std::vector<VehicleStep> still = Corner(kRigid);
  for (VehicleStep& step : still) step.motion.step = 0;
  EXPECT_NE(reason(still).find("still"), std::string::npos);

  std::vector<VehicleStep> straight = Corner(kRigid);
  for (VehicleStep& step : straight) step.motion.psi = 0;
  EXPECT_EQ(reason(straight), "no turning");

  std::vector<VehicleStep> broken = Corner(kRigid);
  broken[0].motion.theta = std::nan("");
  EXPECT_NE(reason(broken).find("number"), std::string::npos);

  std::vector<VehicleStep> scattered = Corner(kRigid);
  scattered.resize(2);
  for (VehicleStep& step : scattered) step.motion.psi = 0.2;
  EXPECT_EQ(reason(scattered), "only 2 of 2 steps are inliers");
}

TEST(PooledLine, WithoutTimesThereIsNoSpeed) {
  std::vector<VehicleStep> untimed = Corner(kRigid);
  for (VehicleStep& step : untimed) step.duration = 0;
  const PooledLine line = LineOf(untimed);
  EXPECT_EQ(line.mean_square_speed, 0);
  EXPECT_NEAR(MetresPerUnit(line, kSlipping) / kMetresPerUnit, 1, 1e-12) << "taken not to slip";
}

TEST(MedianOfSteps, IsTheMedianOfThePapersObserver) {
  std::vector<VehicleStep> steps = Corner(kSlipping);
  steps.resize(19);
  AddSidewaysNoise(0.002, 8, steps);
  std::vector<double> scales;
  for (const VehicleStep& step : steps) {
    const double metres = ObservedDistance(step.motion.psi, step.motion.theta, step.duration, kSlipping);
    scales.push_back(metres > 0 ? metres / step.motion.step : std::numeric_limits<double>::infinity());
  }
  std::ranges::sort(scales);
  EXPECT_NEAR(MedianScaleOf(steps, kSlipping) / scales[9], 1, 1e-9);
}

TEST(MedianOfSteps, SpreadIsThatOfTheSteps) {
  constexpr double kMedianPenalty = 1.2533;  // standard deviation of a median over that of a mean
  constexpr int kEqualSteps = 25;
  double squares = 0;
  double sigma = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    // Steps of one size, as the median takes them all for equal.
    std::vector<VehicleStep> steps(kEqualSteps, EvenCorner(kRigid)[10]);
    AddSidewaysNoise(0.0015, seed, steps);
    const MedianScale median = MedianOfSteps(steps, kRigid);
    squares += std::pow(median.metres_per_unit - kMetresPerUnit, 2);
    sigma += kMedianPenalty * median.spread * median.metres_per_unit / std::sqrt(kEqualSteps);
  }
  EXPECT_NEAR(sigma / kSeeds / std::sqrt(squares / kSeeds), 1, 0.15);
}

TEST(MedianOfSteps, NothingToSeeIsNoScale) {
  EXPECT_EQ(MedianOfSteps({}, kRigid).metres_per_unit, std::numeric_limits<double>::infinity());
  std::vector<VehicleStep> straight(3);
  for (VehicleStep& step : straight) step.motion.step = 1;
  EXPECT_EQ(MedianOfSteps(straight, kRigid).metres_per_unit, std::numeric_limits<double>::infinity());
}

TEST(PooledLineOptions, RefusesSenselessValues) {
  const auto refused = [](auto change) {
    PooledLineOptions options;
    change(options);
    EXPECT_THROW(options.Check(), InputError);
    EXPECT_THROW(PoolTurn(Corner(kRigid), options), InputError);
  };
  EXPECT_NO_THROW(PooledLineOptions{}.Check());
  refused([](auto& o) { o.sigma_theta = 0; });
  refused([](auto& o) { o.robust_threshold = -1; });
  refused([](auto& o) { o.min_inliers = 0; });
  refused([](auto& o) { o.min_angle = -1; });
}

}  // namespace
}  // namespace turnscale
