// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/calibration_trials.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_seeds.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kDeg = 1 / kDegreesPerRadian;

TEST(PaperDrive, HasThePapersShape) {
  const auto steps = PaperDriveSteps();
  ASSERT_EQ(steps.size(), 3499U);
  double heading = 0;
  double way = 0;
  double turned = 0;
  for (const AckermannStep& step : steps) {
    heading += step.psi;
    turned += std::abs(step.psi);
    way += step.rho;
  }
  EXPECT_NEAR(way, 1200, 1e-6);
  EXPECT_NEAR(turned, 9 * 90 * kDeg, 1e-6);
  EXPECT_NEAR(heading, 90 * kDeg, 1e-6);
}

TEST(PaperDrive, SameSeedSameBits) {
  const auto steps = PaperDriveSteps();
  const OdometryNoise noise{0.01, 0.01, 7};
  const Trajectory a = NoisyCameraPath(steps, PaperCalibrationDrive(), noise);
  const Trajectory b = NoisyCameraPath(steps, PaperCalibrationDrive(), noise);
  EXPECT_EQ(a.back().world_from_camera.translation, b.back().world_from_camera.translation);
}

TEST(PaperAngles, TheMiddleOneTurnsAsTheCarDoes) {
  EXPECT_NEAR(YawPitchRollFromRotation(RotationFromPaperAngles(0, 15, 0)).yaw, 15 * kDeg, 1e-12);
  EXPECT_NEAR(YawPitchRollFromRotation(RotationFromPaperAngles(5, 0, 0)).roll, 5 * kDeg, 1e-12);
  EXPECT_NEAR(YawPitchRollFromRotation(RotationFromPaperAngles(0, 0, -10)).pitch, -10 * kDeg, 1e-12);
  // First about z: what looks along x goes to z's side first.
  const Eigen::Vector3d side = RotationFromPaperAngles(90, 0, 30) * Eigen::Vector3d::UnitY();
  EXPECT_NEAR(side.x(), -std::cos(30 * kDeg), 1e-12);
  EXPECT_NEAR(side.z(), std::sin(30 * kDeg), 1e-12);
}

TEST(CalibrationTrials, TheRefinementIsUnbiasedAndNearTheBound) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  CalibrationTrials trials;
  trials.drive = PaperCalibrationDrive();
  trials.rotation_noise = 1 * kDeg;
  trials.runs = 40;
  const YawPitchRoll bound = CramerRaoBound(trials);
  YawPitchRoll mean;
  YawPitchRoll squares;
  const std::vector<CalibrationTrial> runs = RunCalibrationTrials(trials);
  ASSERT_EQ(runs.size(), 40U);
  for (const CalibrationTrial& trial : runs) {
    for (const auto angle : {&YawPitchRoll::yaw, &YawPitchRoll::pitch, &YawPitchRoll::roll}) {
      mean.*angle += trial.refined.*angle / trials.runs;
      squares.*angle += std::pow(trial.refined.*angle, 2) / trials.runs;
    }
  }
  for (const auto angle : {&YawPitchRoll::yaw, &YawPitchRoll::pitch, &YawPitchRoll::roll}) {
    EXPECT_LT(std::abs(mean.*angle), 3 * bound.*angle / std::sqrt(trials.runs));
    // The spread over 40 runs is itself uncertain by 11 %.
    EXPECT_LT(std::sqrt(squares.*angle), 1.3 * bound.*angle);
    EXPECT_GT(std::sqrt(squares.*angle), 0.7 * bound.*angle);
    EXPECT_LT(std::sqrt(squares.*angle), 0.55 * kDeg) << "the paper has 0.5 deg";
  }
}

TEST(CalibrationTrials, DoNotDependOnTheJobs) {
  CalibrationTrials trials;
  trials.rotation_noise = 1 * kDeg;
  trials.runs = 3;
  const std::vector<CalibrationTrial> one = RunCalibrationTrials(trials);
  trials.jobs = 3;
  const std::vector<CalibrationTrial> three = RunCalibrationTrials(trials);
  ASSERT_EQ(one.size(), 3U);
  ASSERT_EQ(three.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(one[i].refined.yaw, three[i].refined.yaw);
  EXPECT_NE(one[0].refined.yaw, one[1].refined.yaw);
}

TEST(CalibrationTrials, WithoutNoiseThereIsNoBound) { EXPECT_THROW(CramerRaoBound({}), InputError); }

TEST(CalibrationTrials, StopWhenAsked) {
  CalibrationTrials trials;
  trials.rotation_noise = 1 * kDeg;
  trials.progress = [](int, int) { return false; };
  EXPECT_TRUE(RunCalibrationTrials(trials).empty());
}

}  // namespace
}  // namespace turnscale
