// SPDX-License-Identifier: MIT
#include "turnscale/calibration/lever_arm_fit.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/base/test_seeds.h"
#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/test_drive.h"
#include "turnscale/kinematics/turn_errors.h"

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
  EXPECT_LT(fit.sigma_length, 0.02);
}

// White noise has no common part; what is stated for the turns' own deviations is in no error here.
TEST(LeverArmFit, NoiseFromFrameToFrameIsNoReasonForALargeSigma) {
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
  EXPECT_GT(stated, squares);
  EXPECT_LT(std::sqrt(stated - squares), 0.02);
}

// How far a world is from the kinematics.
struct WorldErrors {
  double common_velocity = 0.05;  ///< m/s, in each direction
  double common_seconds = 2;
  double side_slip_sigma = 0;  ///< of the car's c
};

// Of a car with a lever arm of 1.45 m and c of about kUsualSideSlip. Each turn deviates from the car as turn_errors.h
// says, and the pose drifts as an inertial one does.
MetricDrive UncertainDrive(const std::vector<int>& turns, const WorldErrors& errors, int seed) {
  Random random(static_cast<std::uint64_t>(seed));
  const double side_slip = kUsualSideSlip + errors.side_slip_sigma * random.Gaussian();
  RigidTransform pose;
  Trajectory path{{0, pose}};
  LeverArm of_segment;
  Eigen::Quaterniond mount = kTilted;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();
  const auto noise = [&] {
    const double x = random.Gaussian();
    const double y = random.Gaussian();
    const double z = random.Gaussian();
    return Eigen::Vector3d(x, y, z);
  };
  velocity = errors.common_velocity * noise();
  const double kept = std::exp(-kStepInterval / errors.common_seconds);
  bool turning = true;
  for (const DriveSegment& segment : TestRoute(turns, 80)) {
    if (turning != (segment.psi != 0)) {
      turning = segment.psi != 0;
      of_segment.length = 1.45 * (1 + kTurnSigma * random.Gaussian());
      of_segment.side_slip = side_slip * (1 + kTurnSlipSigma * random.Gaussian());
      const double direction = (turning ? kTurnDirectionSigma : kStraightDirectionSigma) * random.Gaussian();
      mount = RotationFromYawPitchRoll({direction, 0, 0}) * kTilted;
    }
    for (int i = 0; i < segment.steps; ++i) {
      // The direction of travel differs, not the axis of turning.
      RigidTransform motion = SlippingCameraMotion(segment, kStepInterval, of_segment, mount);
      motion.rotation = SlippingCameraMotion(segment, kStepInterval, of_segment, kTilted).rotation;
      pose = pose * motion;
      velocity = kept * velocity + std::sqrt(1 - kept * kept) * errors.common_velocity * noise();
      drift += kStepInterval * velocity;
      path.push_back({path.back().time + kStepInterval, {pose.rotation, pose.translation + drift}});
    }
  }
  MetricDrive drive{StepsAlong(path)};
  drive.vehicle_from_camera = Calibrate(drive.steps).vehicle_from_camera;
  return drive;
}

LeverArmFitOptions UsualSlip(double sigma) {
  LeverArmFitOptions options;
  options.assumed_side_slip = kUsualSideSlip;
  options.assumed_side_slip_sigma = sigma;
  options.max_relative_sigma = 1;
  return options;
}

struct Coverage {
  double normalized_error = 0;  ///< root mean square
  double mean_sigma = 0;
};

// Each lever arm of so many drives.
Coverage CoverageOf(const std::vector<int>& turns, int drives, const WorldErrors& errors) {
  constexpr int kRuns = 150;
  Coverage coverage;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<MetricDrive> all;
    for (int i = 0; i < drives; ++i) all.push_back(UncertainDrive(turns, errors, 1000 * i + run));
    const LeverArmFit fit = FitLeverArm(all, UsualSlip(errors.side_slip_sigma));
    coverage.normalized_error += std::pow((fit.lever_arm.length - 1.45) / fit.sigma_length, 2) / kRuns;
    coverage.mean_sigma += fit.sigma_length / kRuns;
  }
  coverage.normalized_error = std::sqrt(coverage.normalized_error);
  return coverage;
}

TEST(LeverArmFit, StatesTheSpreadThatItsErrorsHaveForAnyNumberOfTurns) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  const Coverage one = CoverageOf({1}, 1, {});
  const Coverage two = CoverageOf({1, -1}, 1, {});
  const Coverage six = CoverageOf({1, -1, 1, 1, -1, -1}, 1, {});
  const Coverage apart = CoverageOf({1}, 4, {});
  for (const Coverage& coverage : {one, two, six, apart}) {
    EXPECT_GT(coverage.normalized_error, 0.7);
    EXPECT_LT(coverage.normalized_error, 1.3);
  }
  EXPECT_NEAR(six.mean_sigma / one.mean_sigma, 1 / std::sqrt(6), 0.15) << "pooled over turns";
  EXPECT_NEAR(apart.mean_sigma / one.mean_sigma, 1 / std::sqrt(4), 0.15) << "pooled over drives";
}

TEST(LeverArmFit, ErrorsOfTheMotionMayLastShorterOrLonger) {
  for (const double seconds : {1.0, 4.0}) {
    const Coverage coverage = CoverageOf({1}, 1, {.common_seconds = seconds});
    EXPECT_GT(coverage.normalized_error, 0.7) << seconds;
    EXPECT_LT(coverage.normalized_error, 1.3) << seconds;
  }
}

TEST(LeverArmFit, StatesTheErrorOfAnAssumedSlip) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  const Coverage coverage =
      CoverageOf({1, -1, 1, 1, -1, -1}, 1, {.common_velocity = 0.02, .side_slip_sigma = 0.25 * kUsualSideSlip});
  EXPECT_GT(coverage.normalized_error, 0.7);
  EXPECT_LT(coverage.normalized_error, 1.3);
}

TEST(LeverArmFit, AnAssumedSlipAndTheLeverArmErrTogether) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, -1}), {1.45, 0.006}, kTilted, 0.05 * kDeg)), kTilted};
  const LeverArmFit exact = FitLeverArm({drive}, UsualSlip(0));
  const LeverArmFit fit = FitLeverArm({drive}, UsualSlip(0.002));
  EXPECT_EQ(fit.lever_arm.length, exact.lever_arm.length);
  EXPECT_EQ(fit.sigma_side_slip, 0.002);
  EXPECT_EQ(exact.slip_correlation, 0);
  // At 8 m/s.
  EXPECT_NEAR(fit.sigma_length, std::hypot(exact.sigma_length, 64 * 0.002), 1e-3);
  EXPECT_NEAR(fit.SigmaAtExactSlip(), exact.sigma_length, 1e-9);
  const double by_slip = fit.slip_correlation * fit.sigma_length / fit.sigma_side_slip;
  EXPECT_NEAR(fit.lever_arm.length + by_slip * (0.006 - kUsualSideSlip), 1.45, 0.01)
      << "who learns of the slip knows the lever arm";
}

TEST(LeverArmFit, AFittedSlipAndTheLeverArmErrTogether) {
  const MetricDrive drive{StepsAlong(TestPath(TwoSpeeds(), {1.45, 0.005}, kTilted, 0.1 * kDeg)), kTilted};
  LeverArmFitOptions options;
  options.side_slip = true;
  const LeverArmFit fit = FitLeverArm({drive}, options);
  EXPECT_TRUE(fit.slip_fitted);
  EXPECT_GT(fit.slip_correlation, 0.5);
  EXPECT_LT(fit.slip_correlation, 1);
}

TEST(LeverArmFit, TheIntrinsicsAreAsWrongInAllTurns) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, -1}), {1.45, 0}, kTilted)), kTilted};
  LeverArmFitOptions options;
  options.intrinsics_sigma = 0.1;
  EXPECT_NEAR(FitLeverArm({drive}, options).sigma_length, std::hypot(FitLeverArm({drive}).sigma_length, 0.145), 1e-6);
}

TEST(LeverArmFit, SaysWhatWouldMakeTheLeverArmMoreCertain) {
  const MetricDrive drive{StepsAlong(TestPath(TestRoute({1, -1}), {1.45, 0.0045}, kTilted)), kTilted};
  LeverArmFitOptions options = UsualSlip(0.02);
  options.max_relative_sigma = 0.3;
  EXPECT_NE(Complaint(drive, options).find("a more certain side slip"), std::string::npos) << Complaint(drive, options);
  options.assumed_side_slip_sigma = 0;
  EXPECT_EQ(Complaint(drive, options), "");
  options.intrinsics_sigma = 0.4;
  EXPECT_NE(Complaint(drive, options).find("calibration of the camera"), std::string::npos)
      << Complaint(drive, options);
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
  EXPECT_GT(fit.sigma_side_slip, 0) << "not exact";
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
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.assumed_side_slip_sigma = -1; }), "assumed_side_slip_sigma");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.intrinsics_sigma = -1; }), "intrinsics_sigma");
  EXPECT_EQ(RefusedField<Options>([](Options& o) { o.max_relative_sigma = 0; }), "max_relative_sigma");
}

}  // namespace
}  // namespace turnscale
