// SPDX-License-Identifier: MIT
#include "turnscale/calibration/lever_arm_fit.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/test_drive.h"

namespace turnscale {
namespace {

// Turns at two speeds.
std::vector<DriveSegment> TwoSpeeds() {
  std::vector<DriveSegment> route = TestRoute({1, -1});
  for (DriveSegment segment : TestRoute({-1, 1, 1})) {
    segment.camera_distance = 0.4;
    route.push_back(segment);
  }
  return route;
}

std::string Complaint(const MetricDrive& drive, const LeverArmFitOptions& options = {}) {
  try {
    FitLeverArm({drive}, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(LeverArmFit, ReadsTheLeverArmOfARigidCar) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, -1}), {1.45, 0}, kTilted)), kTilted};
  const LeverArmFit fit = FitLeverArm({drive});
  EXPECT_NEAR(fit.lever_arm.length, 1.45, 1e-5);
  EXPECT_EQ(fit.lever_arm.side_slip, 0);
  EXPECT_EQ(fit.sigma_side_slip, 0);
}

TEST(LeverArmFit, KeyframesAtUnequalSpacingShowTheSame) {
  const MetricDrive drive{StepsAlong(EveryFew(TestPath(TestRoute({1, -1, 1}), {1.45, 0}, kTilted))), kTilted};
  const LeverArmFit fit = FitLeverArm({drive});
  EXPECT_NEAR(fit.lever_arm.length, 1.45, 1e-4);
  EXPECT_LT(fit.sigma_length, 0.015);
}

TEST(LeverArmFit, StatesTheSpreadThatItsErrorsHave) {
  constexpr int kRuns = 100;
  double mean = 0;
  double squares = 0;
  double stated = 0;
  for (int run = 0; run < kRuns; ++run) {
    const auto steps =
        StepsAlong(TestPath(TestRoute({1, -1, 1, -1, 1, -1}), {1.45, 0}, kTilted, 0.2 * kDeg, 300 + run));
    const LeverArmFit fit = FitLeverArm({{steps, Calibrate(steps).vehicle_from_camera}});
    mean += (fit.lever_arm.length - 1.45) / kRuns;
    squares += std::pow(fit.lever_arm.length - 1.45, 2) / kRuns;
    stated += std::pow(fit.sigma_length, 2) / kRuns;
  }
  // The noise of the turning angle flattens the line, by the square of noise over angle.
  EXPECT_LT(std::abs(mean), 0.01 * 1.45);
  // The spread over 100 runs is itself uncertain by 7 %. The larger of two sigmas is stated.
  EXPECT_GT(std::sqrt(stated / squares), 0.85);
  EXPECT_LT(std::sqrt(stated / squares), 1.35);
}

TEST(LeverArmFit, TakesTheAssumedSlipAway) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, -1}), {1.45, 0.005}, kTilted)), kTilted};
  LeverArmFitOptions options;
  options.assumed_side_slip = 0.005;
  EXPECT_NEAR(FitLeverArm({drive}, options).lever_arm.length, 1.45, 1e-5);
  EXPECT_EQ(FitLeverArm({drive}, options).lever_arm.side_slip, 0.005);
  // Without it, the effective lever arm at 8 m/s.
  EXPECT_NEAR(FitLeverArm({drive}).lever_arm.length, 1.45 - 0.005 * 64, 1e-5);
}

TEST(LeverArmFit, TellsSlipFromLengthAtTwoSpeeds) {
  const MetricDrive drive{StepsAlong(TestPath(TwoSpeeds(), {1.45, 0.005}, kTilted)), kTilted};
  LeverArmFitOptions options;
  options.side_slip = true;
  const LeverArmFit fit = FitLeverArm({drive}, options);
  EXPECT_NEAR(fit.lever_arm.length, 1.45, 6e-4);
  EXPECT_NEAR(fit.lever_arm.side_slip, 0.005, 1e-5);
  EXPECT_GT(fit.speed_spread, 0.5);
}

TEST(LeverArmFit, RefusesSlipFromTurnsOfOneSpeed) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, -1}), {1.45, 0.005}, kTilted, 0.1 * kDeg)), kTilted};
  LeverArmFitOptions options;
  options.side_slip = true;
  EXPECT_NE(Complaint(drive, options).find("is indistinguishable from the lever arm"), std::string::npos);
}

TEST(LeverArmFit, ASlipBelowZeroIsTakenAsNone) {
  // What drifts inwards with speed is no tyre.
  const MetricDrive drive{StepsAlong(TestPath(TwoSpeeds(), {1.45, -0.002}, kTilted)), kTilted};
  LeverArmFitOptions options;
  options.side_slip = true;
  const LeverArmFit fit = FitLeverArm({drive}, options);
  EXPECT_TRUE(fit.slip_at_bound);
  EXPECT_EQ(fit.lever_arm.side_slip, 0);
  EXPECT_EQ(fit.lever_arm.length, FitLeverArm({drive}).lever_arm.length);
}

TEST(LeverArmFit, RefusesWhatIsNoLeverArm) {
  const MetricDrive behind{StepsAlong(TestPath(TestRoute({1, -1}), {-0.4, 0}, kTilted)), kTilted};
  EXPECT_NE(Complaint(behind).find("ahead of the rear axle"), std::string::npos) << Complaint(behind);
  const MetricDrive noisy{StepsAlong(TestPath(TestRoute({1, -1}), {0.2, 0}, kTilted, 2 * kDeg, 4)), kTilted};
  EXPECT_NE(Complaint(noisy).find("too uncertain"), std::string::npos) << Complaint(noisy);
}

TEST(LeverArmFit, AnErrorOfTheYawIsNoLeverArm) {
  const Eigen::Quaterniond off = RotationFromYawPitchRoll({1 * kDeg, 0, 0}) * kTilted;
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, 1}), {1.45, 0}, kTilted)), off};
  EXPECT_NEAR(FitLeverArm({drive}).lever_arm.length, 1.45, 0.003);
}

// Of corners out of which the car accelerates, on springs: it leans more and more while it turns.
std::vector<CameraStep> LeaningSteps(const BodyRoll& body) {
  std::vector<DriveSegment> route;
  for (const double side : {1.0, -1.0, -1.0, 1.0}) {
    route.push_back({60, 0.4, 0});
    for (const double way : {0.4, 0.5, 0.6, 0.7, 0.8}) route.push_back({6, way, side * 3 * kDeg});
    route.push_back({60, 0.8, 0});
  }
  CarDrive drive = MakeCarDrive(route, kStepInterval, {1.45, 0}, kTilted);
  RollBody(drive.world_from_camera, kTilted, body, drive.dt);
  Random random(7);
  Trajectory path;
  for (RigidTransform pose : drive.world_from_camera) {
    for (int i = 0; i < 3; ++i) pose.translation[i] += 0.003 * random.Gaussian();
    path.push_back({kStepInterval * static_cast<double>(path.size()), pose});
  }
  return StepsAlong(path);
}

TEST(LeverArmFit, RollOfTheBodyIsNoLeverArm) {
  const auto fit = [](const BodyRoll& body) { return FitLeverArm({{LeaningSteps(body), kTilted}}); };
  const LeverArmFit rigid = fit({kUsualRollHeight, 0});
  const LeverArmFit usual = fit({kUsualRollHeight, 0.0107});
  const LeverArmFit higher = fit({kUsualRollHeight + kUsualRollHeightSigma, 0.0107});
  EXPECT_NEAR(usual.lever_arm.length, rigid.lever_arm.length, 0.005);
  EXPECT_NEAR(usual.lever_arm.length, 1.45, 2 * usual.sigma_length);
  const double off = std::abs(higher.lever_arm.length - usual.lever_arm.length);
  EXPECT_GT(off, 0.006) << "the roll is worth taking away";
  EXPECT_NEAR(std::sqrt(std::pow(usual.sigma_length, 2) - std::pow(rigid.sigma_length, 2)), off, 0.25 * off)
      << "the height is not known, whatever the number of turns";
}

TEST(LeverArmFit, NeedsATurn) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({}), {1.45, 0}, kTilted)), kTilted};
  EXPECT_NE(Complaint(drive).find("no turn"), std::string::npos);
}

TEST(LeverArmFitOptions, RefuseSenselessValues) {
  using Options = LeverArmFitOptions;
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.assumed_side_slip = -1; }), "assumed_side_slip");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.huber_share = 0; }), "huber_share");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.min_turn = 0; }), "min_turn");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.min_speed_spread = -1; }), "min_speed_spread");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.max_relative_sigma = 0; }), "max_relative_sigma");
}

}  // namespace
}  // namespace turnscale
