// SPDX-License-Identifier: MIT
#include "turnscale/odometry/calibration_pass.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

using Change = IntrinsicsChange;

constexpr double kFocalSigma = 0.01;
constexpr double kAspectSigma = 0.02;
constexpr int kStrictPasses = 5;  // so many passes, of which the last one has the usual thresholds

const CameraModel kCamera = CameraOfView(70, 640, 360);

// By so many sigmas, where nothing else changes.
PassFindings Changes(double focal_sigmas, double aspect_sigmas = 0) {
  PassFindings findings{.estimate = {}, .radius = 300, .windows = 4};
  IntrinsicsEstimate& estimate = findings.estimate;
  estimate.change[Change::kLogFocal] = kFocalSigma * focal_sigmas;
  estimate.change[Change::kLogAspect] = kAspectSigma * aspect_sigmas;
  estimate.covariance.setIdentity();
  estimate.covariance(Change::kLogFocal, Change::kLogFocal) = kFocalSigma * kFocalSigma;
  estimate.covariance(Change::kLogAspect, Change::kLogAspect) = kAspectSigma * kAspectSigma;
  if (aspect_sigmas == 0) estimate.held = {Change::kLogAspect};
  return findings;
}

double LogFocal(const CameraModel& camera) { return std::log(camera.pinhole.fx / kCamera.pinhole.fx); }
double LogAspect(const CameraModel& camera) { return std::log(camera.pinhole.fy / camera.pinhole.fx); }

TEST(CalibrationPass, TheFirstPassesAreLoose) {
  EXPECT_GT(LooseBy(0), LooseBy(1));
  EXPECT_GT(LooseBy(kStrictPasses - 3), 1);
  EXPECT_EQ(LooseBy(kStrictPasses - 1), 1);
}

TEST(CalibrationPass, TheChangeBetweenPinholesLeadsFromOneToTheOther) {
  const Pinhole from{500, 600, 320, 180};
  const Pinhole to{450, 700, 310, 190};
  const Pinhole changed = ChangedPinhole(from, ChangeBetween(from, to));
  EXPECT_NEAR(changed.fx, to.fx, 1e-9);
  EXPECT_NEAR(changed.fy, to.fy, 1e-9);
  EXPECT_NEAR(changed.cx, to.cx, 1e-9);
  EXPECT_NEAR(changed.cy, to.cy, 1e-9);
}

TEST(CalibrationPass, ASmallChangeEndsAStrictPassHalfway) {
  const auto loose = CameraFrom({}, kCamera, Changes(0.4), 1);
  ASSERT_TRUE(loose);
  EXPECT_FALSE(loose->is_last);
  const auto strict = CameraFrom({}, kCamera, Changes(0.4), kStrictPasses);
  ASSERT_TRUE(strict);
  EXPECT_TRUE(strict->is_last);
  EXPECT_TRUE(strict->found.converged);
  EXPECT_NEAR(LogFocal(strict->next), 0.4 * kFocalSigma, 1e-9);
  EXPECT_NEAR(LogFocal(strict->found.camera), 0.2 * kFocalSigma, 1e-9);
  EXPECT_NEAR(strict->found.camera.focal_sigma / strict->found.camera.pinhole.fx,
              std::hypot(kFocalSigma, 0.2 * kFocalSigma), 1e-9);
  EXPECT_EQ(strict->found.windows, 4);
}

TEST(CalibrationPass, TheLastPassAlternatesWithinTwoSigmas) {
  const SelfCalibrationOptions options;
  const auto near = CameraFrom(options, kCamera, Changes(1.9), options.max_passes);
  ASSERT_TRUE(near);
  EXPECT_TRUE(near->is_last);
  EXPECT_TRUE(near->found.converged);
  EXPECT_NEAR(LogFocal(near->found.camera), 0.95 * kFocalSigma, 1e-9);
  const auto far = CameraFrom(options, kCamera, Changes(2.1), options.max_passes);
  ASSERT_TRUE(far);
  EXPECT_TRUE(far->is_last);
  EXPECT_FALSE(far->found.converged);
  EXPECT_NEAR(LogFocal(far->found.camera), 2.1 * kFocalSigma, 1e-9);
  const auto before = CameraFrom(options, kCamera, Changes(1.9), options.max_passes - 1);
  ASSERT_TRUE(before);
  EXPECT_FALSE(before->is_last);
}

TEST(CalibrationPass, AnAspectThatWasFoundHasASigma) {
  const auto result = CameraFrom({}, kCamera, Changes(0, 0.4), kStrictPasses);
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->is_last);
  EXPECT_NEAR(LogAspect(result->found.camera), 0.2 * kAspectSigma, 1e-9);
  EXPECT_NEAR(result->found.camera.aspect_sigma, std::hypot(kAspectSigma, 0.2 * kAspectSigma), 1e-12);
  const auto square = CameraFrom({}, kCamera, Changes(0.4), kStrictPasses);
  ASSERT_TRUE(square);
  EXPECT_EQ(square->found.camera.aspect_sigma, 0);
  const auto far = CameraFrom({}, kCamera, Changes(0, 4), kStrictPasses);
  ASSERT_TRUE(far);
  EXPECT_FALSE(far->is_last) << "it has only been found";
}

TEST(CalibrationPass, AnAspectThatGoesBackIsTriedBeforeItEnds) {
  PassFindings back = Changes(0, 0.4);
  back.estimate.held = {Change::kLogAspect};
  const auto result = CameraFrom({}, kCamera, back, kStrictPasses);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->is_last);
  EXPECT_NEAR(LogAspect(result->next), 0.4 * kAspectSigma, 1e-9);
  EXPECT_EQ(result->found.camera.aspect_sigma, 0);
}

TEST(CalibrationPass, AnAspectThatIsHeldIsAsUncertainAsAtTheStart) {
  CameraModel start = kCamera;
  start.aspect_sigma = 0.03;
  const auto held = CameraFrom({}, start, Changes(0.4), kStrictPasses);
  ASSERT_TRUE(held);
  EXPECT_EQ(held->found.camera.aspect_sigma, 0.03);
  const auto found = CameraFrom({}, start, Changes(0, 0.4), kStrictPasses);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->found.camera.aspect_sigma, std::hypot(kAspectSigma, 0.2 * kAspectSigma), 1e-12);
  EXPECT_EQ(found->next.aspect_sigma, 0.03) << "a later pass may go back to the start's";
}

TEST(CalibrationPass, TheImagesAreReadAsBefore) {
  CameraModel sideways = kCamera;
  sideways.read_direction = {-1, 0};
  const auto result = CameraFrom({}, sideways, Changes(0.4), kStrictPasses);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->next.read_direction, sideways.read_direction);
  EXPECT_EQ(result->found.camera.read_direction, sideways.read_direction);
}

TEST(CalibrationPass, AReadoutThatIsFoundIsNotKnownToTheNextPass) {
  CameraModel start = kCamera;
  start.readout = 0.02;
  start.readout_sigma = 0.002;
  PassFindings findings = Changes(0.4);
  const auto unread = CameraFrom({}, start, findings, kStrictPasses);
  ASSERT_TRUE(unread);
  EXPECT_EQ(unread->found.camera.readout, start.readout);
  findings.readout = ShutterReadout{.seconds = 0.022, .sigma = 0.001, .direction = {1, 0}};
  const auto result = CameraFrom({}, start, findings, kStrictPasses);
  ASSERT_TRUE(result);
  EXPECT_EQ(result->found.camera.readout, 0.022);
  EXPECT_EQ(result->found.camera.readout_sigma, 0.001);
  EXPECT_EQ(result->found.camera.read_direction, (ReadDirection{1, 0}));
  EXPECT_EQ(result->next.readout, start.readout);
  EXPECT_EQ(result->next.readout_sigma, start.readout_sigma);
  EXPECT_EQ(result->next.read_direction, start.read_direction);
}

}  // namespace
}  // namespace turnscale
