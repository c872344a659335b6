// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/pooled_scale.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/kinematics/synthetic_drive.h"

namespace turnscale {
namespace {

const LeverArm kRigid{1.2, 0};
const LeverArm kSlipping{1.2, 0.005};
constexpr double kMetresPerUnit = 7.0;
constexpr int kSteps = 20;
constexpr int kSeeds = 200;

/// A corner of 90 degrees taken while braking and speeding up again, in units of 7 m.
std::vector<TurningStep> Corner(const LeverArm& lever_arm, double side = 1) {
  std::vector<TurningStep> corner;
  for (int i = 0; i < kSteps; ++i) {
    const double middle = std::sin(M_PI * (i + 0.5) / kSteps);
    const DriveSegment segment{1, 1.0 - 0.5 * middle, side * middle * M_PI * M_PI / (4.0 * kSteps)};
    const Eigen::Quaterniond identity = Eigen::Quaterniond::Identity();
    TurningMotion motion = TurningMotionOf(SlippingCameraMotion(segment, 0.1, lever_arm, identity), identity);
    motion.step /= kMetresPerUnit;
    corner.push_back({motion, 0.1});
  }
  return corner;
}

/// Moves the camera sideways by normal noise of `sigma` units in each step.
void AddSidewaysNoise(double sigma, unsigned seed, std::vector<TurningStep>& steps) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  for (TurningStep& step : steps) {
    const double sideways = step.motion.step * std::sin(step.motion.theta) + normal(random);
    const double forward = step.motion.step * std::cos(step.motion.theta);
    step.motion.theta = std::atan2(sideways, forward);
    step.motion.step = std::hypot(sideways, forward);
  }
}

double Scale(const std::vector<TurningStep>& steps, const LeverArm& lever_arm, const PooledScaleOptions& options = {}) {
  const PooledScaleResult result = PoolScale(steps, lever_arm, options);
  EXPECT_TRUE(result.scale) << result.reason;
  return result.scale ? result.scale->metres_per_unit : std::nan("");
}

PooledScaleOptions PerFrame() {
  PooledScaleOptions options;
  options.method = ScaleMethod::kPerFrame;
  return options;
}

TEST(PooledScale, ExactWithoutNoiseRigidAndSlipping) {
  for (const LeverArm& lever_arm : {kRigid, kSlipping}) {
    EXPECT_NEAR(Scale(Corner(lever_arm), lever_arm) / kMetresPerUnit, 1.0, 1e-12);
    EXPECT_NEAR(Scale(Corner(lever_arm), lever_arm, PerFrame()) / kMetresPerUnit, 1.0, 1e-12);
  }
  EXPECT_GT(Scale(Corner(kSlipping), kRigid), 1.1 * kMetresPerUnit) << "the slip is worth modelling here";
}

TEST(PooledScale, ReportsInliersAndLeverArm) {
  const PooledScale scale = PoolScale(Corner(kSlipping), kSlipping).scale.value();
  EXPECT_EQ(scale.inliers, 20);
  EXPECT_LT(scale.effective_lever_arm, kSlipping.At(5.0));
  EXPECT_GT(scale.effective_lever_arm, kSlipping.At(7.0));
  EXPECT_NEAR(ObservedLeverArm(Corner(kRigid), kMetresPerUnit).value(), kRigid.length, 1e-12);
  EXPECT_NEAR(ObservedLeverArm(Corner(kSlipping), kMetresPerUnit).value(), scale.effective_lever_arm, 0.02);
}

TEST(PooledScale, LeftAndRightAreMirrorImages) {
  std::vector<TurningStep> right = Corner(kSlipping);
  AddSidewaysNoise(0.001, 5, right);
  std::vector<TurningStep> left = right;
  for (TurningStep& step : left) {
    step.motion.psi *= -1;
    step.motion.theta *= -1;
  }
  const PooledScale a = PoolScale(right, kSlipping).scale.value();
  const PooledScale b = PoolScale(left, kSlipping).scale.value();
  EXPECT_EQ(a.metres_per_unit, b.metres_per_unit);
  EXPECT_EQ(a.sigma, b.sigma);
  EXPECT_NEAR(Scale(Corner(kSlipping, -1), kSlipping) / kMetresPerUnit, 1.0, 1e-12);
}

TEST(PooledScale, HoldsInReverse) {
  std::vector<TurningStep> steps = Corner(kRigid);
  for (TurningStep& step : steps) {
    // The same step seen from its end, backwards.
    step.motion.theta = M_PI + step.motion.theta - step.motion.psi;
    step.motion.psi *= -1;
  }
  EXPECT_NEAR(Scale(steps, kRigid) / kMetresPerUnit, 1.0, 1e-12);
}

TEST(PooledScale, UnitOfLengthCancels) {
  std::vector<TurningStep> steps = Corner(kSlipping);
  AddSidewaysNoise(0.002, 6, steps);
  for (const PooledScaleOptions& options : {PooledScaleOptions{}, PerFrame()}) {
    const PooledScale before = PoolScale(steps, kSlipping, options).scale.value();
    for (const double k : {1e-3, 0.1, 3.0, 1e4}) {
      std::vector<TurningStep> scaled = steps;
      for (TurningStep& step : scaled) step.motion.step *= k;
      const PooledScale after = PoolScale(scaled, kSlipping, options).scale.value();
      EXPECT_NEAR(after.metres_per_unit * k / before.metres_per_unit, 1.0, 1e-12);
      EXPECT_NEAR(after.sigma * k / before.sigma, 1.0, 1e-9);
      EXPECT_EQ(after.inliers, before.inliers);
    }
  }
}

TEST(PooledScale, SpreadAgreesWithSigma) {
  for (const LeverArm& lever_arm : {kRigid, kSlipping}) {
    double sum = 0;
    double squares = 0;
    double sigma = 0;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      std::vector<TurningStep> steps = Corner(lever_arm);
      AddSidewaysNoise(0.0015, seed, steps);
      const PooledScale scale = PoolScale(steps, lever_arm).scale.value();
      sum += scale.metres_per_unit;
      squares += scale.metres_per_unit * scale.metres_per_unit;
      sigma += scale.sigma;
    }
    const double mean = sum / kSeeds;
    const double spread = std::sqrt(squares / kSeeds - mean * mean);
    EXPECT_NEAR(sigma / kSeeds / spread, 1.0, 0.25);
    EXPECT_LT(std::abs(mean / kMetresPerUnit - 1), 3 * spread / kMetresPerUnit / std::sqrt(kSeeds));
  }
}

TEST(PooledScale, PoolingBeatsThePerFrameObserver) {
  double pooled = 0;
  double per_frame = 0;
  for (unsigned seed = 0; seed < 100; ++seed) {
    std::vector<TurningStep> steps = Corner(kRigid);
    AddSidewaysNoise(0.003, seed, steps);
    pooled += std::pow(Scale(steps, kRigid) - kMetresPerUnit, 2);
    per_frame += std::pow(Scale(steps, kRigid, PerFrame()) - kMetresPerUnit, 2);
  }
  EXPECT_LT(pooled, 0.8 * per_frame);
}

TEST(PooledScale, GrossOutliersHaveNoSay) {
  std::vector<TurningStep> steps = Corner(kSlipping);
  AddSidewaysNoise(0.001, 7, steps);
  const double clean = Scale(steps, kSlipping);
  for (const double theta : {-1.0, 1.0, -2.0}) {
    std::vector<TurningStep> spoilt = steps;
    spoilt[9].motion.theta = theta;
    spoilt[10].motion.theta = theta;
    const PooledScale scale = PoolScale(spoilt, kSlipping).scale.value();
    EXPECT_NEAR(scale.metres_per_unit / clean, 1.0, 0.05);
    EXPECT_EQ(scale.inliers, 18);
  }
}

TEST(PooledScale, FewExactStepsDoNotThrowOutAGoodOne) {
  const std::vector<TurningStep> corner = Corner(kRigid);
  std::vector<TurningStep> steps(corner.begin() + 8, corner.begin() + 12);
  steps[1].motion.theta += 0.004;
  const PooledScale scale = PoolScale(steps, kRigid).scale.value();
  EXPECT_EQ(scale.inliers, 4);
  EXPECT_GT(scale.sigma, 0.005 * scale.metres_per_unit) << "four steps are not believed to be without noise";
}

TEST(PooledScale, SaysWhyThereIsNoScale) {
  const auto reason = [](const std::vector<TurningStep>& steps, const LeverArm& lever_arm) {
    const PooledScaleResult result = PoolScale(steps, lever_arm);
    EXPECT_FALSE(result.scale);
    return result.reason;
  };
  EXPECT_EQ(reason({}, kRigid), "no steps");

  std::vector<TurningStep> inwards = Corner(kRigid);
  for (TurningStep& step : inwards) step.motion.theta = step.motion.psi - step.motion.theta;
  EXPECT_NE(reason(inwards, kRigid).find("swing outwards"), std::string::npos);
  EXPECT_NE(reason(inwards, kSlipping).find("effective lever arm"), std::string::npos);

  std::vector<TurningStep> untimed = Corner(kRigid);
  untimed[3].dt = 0;
  EXPECT_NE(reason(untimed, kSlipping).find("time"), std::string::npos);
  EXPECT_NEAR(Scale(untimed, kRigid) / kMetresPerUnit, 1.0, 1e-12);

  std::vector<TurningStep> bend = Corner(kRigid);
  bend.resize(3);
  EXPECT_NE(reason(bend, kRigid).find("deg"), std::string::npos);

  std::vector<TurningStep> still = Corner(kRigid);
  for (TurningStep& step : still) step.motion.step = 0;
  EXPECT_NE(reason(still, kRigid).find("still"), std::string::npos);

  std::vector<TurningStep> broken = Corner(kRigid);
  broken[0].motion.theta = std::nan("");
  EXPECT_NE(reason(broken, kRigid).find("number"), std::string::npos);

  EXPECT_THROW(PoolScale(Corner(kRigid), {0, 0}), InputError);
  EXPECT_THROW(PoolScale(Corner(kRigid), {1, -0.1}), InputError);
}

}  // namespace
}  // namespace turnscale
