// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/scale_observer.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/synthetic_drive.h"
#include "turnscale/kinematics/turning_motion.h"

namespace turnscale {
namespace {

constexpr double kStep = 1e-6;  // rad
constexpr int kDraws = 20000;

TEST(ScaleObserver, ExactOnConstrainedMotion) {
  std::mt19937 random(21);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const AckermannStep step{std::copysign(0.02 + 0.3 * std::abs(uniform(random)), uniform(random)),
                             1.2 + uniform(random)};
    const double lever_arm = 1.5 + uniform(random);
    const double theta = DirectionOfTravel(step, lever_arm);
    const double truth = CameraDistance(step, lever_arm);
    EXPECT_NEAR(ObservedDistance(step.psi, theta, lever_arm) / truth, 1.0, 1e-11);
    const double sine_rule = 2 * lever_arm * std::sin(step.psi) / (std::sin(theta) - std::sin(step.psi - theta));
    EXPECT_NEAR(sine_rule / truth, 1.0, 1e-11) << "the mended form of (22)";
  }
}

TEST(ScaleObserver, ExactOnASlippingCarEitherWay) {
  const LeverArm lever_arm{1.2, 0.005};
  const Eigen::Quaterniond identity = Eigen::Quaterniond::Identity();
  for (const double psi : {0.06, -0.06}) {
    const TurningMotion motion =
        TurningMotionOf(SlippingCameraMotion({1, 0.9, psi}, 0.1, lever_arm, identity), identity);
    EXPECT_NEAR(ObservedDistance(motion.psi, motion.theta, 0.1, lever_arm), 0.9, 1e-12);
    EXPECT_GT(ObservedDistance(motion.psi, motion.theta, lever_arm.length), 1.3) << "the rigid car is far off here";
    EXPECT_EQ(ObservedDistance(motion.psi, motion.theta, 0.1, {1.2, 0}),
              ObservedDistance(motion.psi, motion.theta, 1.2));
  }
}

TEST(ScaleObserver, ContradictionGivesNoPositiveDistance) {
  EXPECT_LT(ObservedDistance(0.1, 0.04, 1.0), 0) << "the camera swings inwards";
  EXPECT_FALSE(std::isfinite(ObservedDistance(0.1, 0.05, 1.0))) << "the camera moves along the chord of the axle";
}

TEST(ScaleObserver, DerivativesAgreeWithFiniteDifferences) {
  for (const double psi : {-0.3, -0.04, 0.05, 0.2}) {
    for (const double ratio : {0.6, 0.8, 1.1}) {
      const double theta = ratio * psi;
      const double by_psi =
          (ObservedDistance(psi + kStep, theta, 1) - ObservedDistance(psi - kStep, theta, 1)) / (2 * kStep);
      const double by_theta =
          (ObservedDistance(psi, theta + kStep, 1) - ObservedDistance(psi, theta - kStep, 1)) / (2 * kStep);
      const ScaleSensitivity sensitivity = SensitivityOfScale(psi, theta);
      EXPECT_NEAR(sensitivity.by_psi / by_psi, 1.0, 1e-5);
      EXPECT_NEAR(sensitivity.by_theta / by_theta, 1.0, 1e-5);
    }
  }
}

TEST(ScaleObserver, SigmaIsTheSpreadOfNoisyAngles) {
  const AckermannStep step{0.08, 0.5};
  const double theta = DirectionOfTravel(step, 1.0);
  const double sigma_psi = 2e-4;
  const double sigma_theta = 5e-4;
  std::mt19937 random(22);
  std::normal_distribution<double> normal;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double noisy_psi = step.psi + sigma_psi * normal(random);
    const double s = ObservedDistance(noisy_psi, theta + sigma_theta * normal(random), 1.0);
    sum += s;
    squares += s * s;
  }
  const double mean = sum / kDraws;
  const double spread = std::sqrt(squares / kDraws - mean * mean);
  EXPECT_NEAR(ObservedDistanceSigma(step.psi, theta, 1.0, sigma_psi, sigma_theta) / spread, 1.0, 0.015);
}

}  // namespace
}  // namespace turnscale
