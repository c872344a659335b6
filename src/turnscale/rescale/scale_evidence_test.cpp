// SPDX-License-Identifier: MIT
#include "turnscale/rescale/scale_evidence.h"

#include <cmath>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

constexpr double kLeverArm = 1.3;
constexpr double kScale = 12;
constexpr StretchNoise kNoise{0.04, 0.002};
const DriveState kState(std::log(kScale), 0.006, 0.005, 1.4);

std::vector<SwayStep> Turn(double noise) {
  Random random(4);
  std::vector<SwayStep> steps;
  for (int i = 0; i < 30; ++i) {
    SwayStep step;
    step.psi = 0.06 + 0.03 * random.Gaussian();
    step.length = 0.08;
    step.speed = 0.4 + 0.1 * random.Uniform();
    step.roll = 0.003 * random.Gaussian();
    step.sway = SwayRegressors(step).dot(SwayCoefficients(kState, kLeverArm)) + noise * random.Gaussian();
    steps.push_back(step);
  }
  return steps;
}

StretchObservation ObservationOf(const std::vector<SwayStep>& steps, double sigma) {
  StretchObservation observation;
  observation.pooled = PoolSway(steps, Eigen::Vector4d::Zero(), sigma, 1e9);
  observation.turning = true;
  observation.lever_weight = 0.7;
  return observation;
}

// The cost with the stretch's random effects in it.
double FullCost(const StretchObservation& observation, const DriveState& state, const Eigen::Vector2d& effects) {
  Eigen::Vector4d coefficients = SwayCoefficients(state, kLeverArm);
  coefficients[0] *= 1 + effects[0];
  coefficients[2] += effects[1];
  return observation.pooled.Cost(coefficients) + observation.lever_weight * std::pow(effects[0] / kNoise.lever, 2) +
         observation.direction_weight * std::pow(effects[1] / kNoise.direction, 2);
}

TEST(PooledSway, CostIsTheSumOfSquares) {
  const std::vector<SwayStep> steps = Turn(1e-3);
  const PooledSway pooled = PoolSway(steps, Eigen::Vector4d::Zero(), 2e-3, 1e9);
  const Eigen::Vector4d coefficients(0.1, 0.03, 0.004, 0.2);
  double sum = 0;
  for (const SwayStep& step : steps) sum += std::pow((step.sway - SwayRegressors(step).dot(coefficients)) / 2e-3, 2);
  EXPECT_NEAR(pooled.Cost(coefficients) / sum, 1, 1e-10);
}

TEST(PooledSway, FarStepsLoseWeight) {
  std::vector<SwayStep> steps = Turn(0);
  const Eigen::Vector4d truth = SwayCoefficients(kState, kLeverArm);
  steps[3].sway += 1;
  const PooledSway pooled = PoolSway(steps, truth, 1e-3, 2);
  EXPECT_NEAR(pooled.Cost(truth), 2 * 1000, 1e-3) << "Huber: a residual of 1000 sigmas has the weight 2/1000";
}

TEST(ScaleEvidence, CoefficientsHaveTheDerivativesOfFiniteDifferences) {
  const Eigen::Matrix4d jacobian = SwayCoefficientsJacobian(kState, kLeverArm);
  for (int i = 0; i < 4; ++i) {
    const DriveState step = 1e-6 * DriveState::Unit(i);
    const Eigen::Vector4d numeric =
        (SwayCoefficients(kState + step, kLeverArm) - SwayCoefficients(kState - step, kLeverArm)) / 2e-6;
    EXPECT_LT((jacobian.col(i) - numeric).norm(), 1e-8 * (1 + numeric.norm()));
  }
}

TEST(ScaleEvidence, GradientIsThatOfTheCostWithRandomEffectsEliminated) {
  const StretchObservation observation = ObservationOf(Turn(1e-3), 1e-3);
  const DriveState at = kState + DriveState(0.01, 1e-4, 1e-4, 0.02);
  const ScaleEvidence evidence = EvidenceAt(observation, at, kLeverArm, kNoise);
  // Of the full cost at the best random effects, by the state: the envelope theorem, the effects at first order.
  const Eigen::Vector2d effects = evidence.effects_covariance * evidence.effects_gradient;
  EXPECT_LT(FullCost(observation, at, effects), FullCost(observation, at, {0, 0}));
  for (const Eigen::Vector2d& off : {Eigen::Vector2d(1e-4, 0), Eigen::Vector2d(0, 1e-5)}) {
    EXPECT_GT(FullCost(observation, at, effects + off), FullCost(observation, at, effects));
    EXPECT_GT(FullCost(observation, at, effects - off), FullCost(observation, at, effects));
  }
  const auto profile = [&](const DriveState& state) {
    const ScaleEvidence there = EvidenceAt(observation, state, kLeverArm, kNoise);
    return FullCost(observation, state, there.effects_covariance * there.effects_gradient);
  };
  for (const int unknown : {kTravel, kSlip, kHeight}) {
    const DriveState step = (unknown == kHeight ? 1e-4 : 1e-7) * DriveState::Unit(unknown);
    const double numeric = (profile(at + step) - profile(at - step)) / (2 * step.norm());
    EXPECT_NEAR(-2 * evidence.gradient[unknown] / numeric, 1, 1e-4);
  }
}

TEST(ScaleEvidence, RandomEffectsBoundWhatATurnCanSay) {
  std::vector<SwayStep> steps = Turn(0);
  for (SwayStep& step : steps) {
    step.speed = 0.45;
    step.roll = 0;
  }
  for (const double sigma : {1e-4, 1e-6}) {
    const ScaleEvidence evidence = EvidenceAt(ObservationOf(steps, sigma), kState, kLeverArm, kNoise);
    const double slip = kState[kSlip] * MeanSquareSpeed(ObservationOf(steps, sigma).pooled) * kScale * kScale;
    EXPECT_GT(1 / std::sqrt(evidence.information(kLogScale, kLogScale)),
              0.99 * kNoise.lever / std::sqrt(0.7) * kLeverArm / (kLeverArm + slip));
  }
}

TEST(ScaleEvidence, StraightsAreNotAskedForTheScale) {
  StretchObservation observation = ObservationOf(Turn(1e-3), 1e-3);
  observation.turning = false;
  const ScaleEvidence evidence = EvidenceAt(observation, kState, kLeverArm, kNoise);
  EXPECT_EQ(evidence.information(kLogScale, kLogScale), 0);
  EXPECT_EQ(evidence.gradient[kLogScale], 0);
}

TEST(ScaleEvidence, OneTurnShowsItsScale) {
  const StretchObservation observation = ObservationOf(Turn(0), 1e-3);
  const auto scale = ScaleOfStretch(observation.pooled, kState, kLeverArm);
  ASSERT_TRUE(scale);
  EXPECT_NEAR(*scale / kScale, 1, 1e-9);
  EXPECT_NEAR(LeverArmRatio(observation.pooled, kState, kLeverArm), 1 - 0.005 * std::pow(0.45 * kScale, 2) / kLeverArm,
              0.02);
}

TEST(ScaleEvidence, ContradictionHasNoScale) {
  std::vector<SwayStep> steps = Turn(0);
  for (SwayStep& step : steps) step.sway = -std::abs(step.sway) * (step.psi > 0 ? 1 : -1), step.speed = 0;
  DriveState rigid = kState;
  rigid[kSlip] = 0;
  EXPECT_FALSE(ScaleOfStretch(ObservationOf(steps, 1e-3).pooled, rigid, kLeverArm));
}

}  // namespace
}  // namespace turnscale
