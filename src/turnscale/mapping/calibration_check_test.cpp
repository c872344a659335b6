// SPDX-License-Identifier: MIT
#include "turnscale/mapping/calibration_check.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/test_seeds.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_calibration.h"
#include "turnscale/mapping/test_intrinsics.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

TEST(CalibrationCheck, FindsAWrongFocalLength) {
  for (const double percent : {15.0, -15.0, 5.0, -5.0})
    for (int seed = 1; seed <= SeedsToTest(2); ++seed) {
      const Vector error = Change(std::log(1 + percent / 100), 0, 0, 0);
      const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, error, 0.3, static_cast<unsigned>(seed)));
      const std::vector<ParameterEstimate> found = check.Contradictions(WithCorrection());
      ASSERT_EQ(found.size(), 1U) << percent;
      EXPECT_EQ(found[0].parameter, IntrinsicsParameter::kFocalLength);
      EXPECT_NEAR(found[0].given, 718 * (1 + percent / 100), 1e-6);
      EXPECT_NEAR(found[0].found, 718, 1.6 * found[0].sigma);
      EXPECT_LT(found[0].sigma, 0.015 * 718);
    }
}

TEST(CalibrationCheck, FindsAWrongPrincipalPoint) {
  for (const Vector& error : {Change(0, 25, 0, 0), Change(0, 0, -25, 0)}) {
    const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, error, 0.3, 3));
    const ParameterEstimate x = Of(IntrinsicsParameter::kCentreX, check);
    const ParameterEstimate y = Of(IntrinsicsParameter::kCentreY, check);
    EXPECT_NEAR(x.found, 607, 0.2 * x.sigma);
    EXPECT_NEAR(y.found, 185, 0.2 * y.sigma);
    const std::vector<ParameterEstimate> found = check.Contradictions(WithCorrection());
    ASSERT_EQ(found.size(), 1U) << error.transpose();
    EXPECT_EQ(found[0].parameter,
              error[IntrinsicsChange::kCentreX] != 0 ? IntrinsicsParameter::kCentreX : IntrinsicsParameter::kCentreY);
  }
}

TEST(CalibrationCheck, AnErrorTooSmallForAReportLeavesTheCalibrationInDoubt) {
  const auto verdict = [](double pixels) {
    const Vector error = Change(0, pixels, 0, 0);
    return CheckAlong(WrongMap(kRightAndLeft, error, 0.3, 3)).Verdict(WithCorrection());
  };
  EXPECT_EQ(verdict(0), CalibrationVerdict::kNotContradicted);
  EXPECT_EQ(verdict(8), CalibrationVerdict::kInDoubt);
  EXPECT_EQ(verdict(25), CalibrationVerdict::kContradicted);
  EXPECT_EQ(CalibrationCheck({}, kTestPinhole).Verdict(WithCorrection()), CalibrationVerdict::kNotContradicted);
}

TEST(CalibrationCheck, ADoubtIsLargeAndLessThanAContradiction) {
  const auto check_of = [](double pixels) {
    CalibrationCheckOptions options;
    options.significance = 15;
    return CheckAlong(WrongMap(kRightAndLeft, Change(0, pixels, 0, 0), 0.3, 3), options);
  };
  EXPECT_TRUE(check_of(0).Doubts(WithCorrection()).empty());
  EXPECT_TRUE(check_of(5).Doubts(WithCorrection()).empty()) << "too small for a report";
  const CalibrationCheck check = check_of(25);
  EXPECT_TRUE(check.Contradictions(WithCorrection()).empty());
  const std::vector<ParameterEstimate> doubts = check.Doubts(WithCorrection());
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_EQ(doubts[0].parameter, IntrinsicsParameter::kCentreX);
  EXPECT_TRUE(CheckAlong(WrongMap(kRightAndLeft, Change(0, 25, 0, 0), 0.3, 3)).Doubts(WithCorrection()).empty())
      << "contradicted";
}

TEST(CalibrationCheck, AFocalLengthThatIsNotDeterminedIsInDoubt) {
  EXPECT_FALSE(CalibrationCheck({}, kTestPinhole).DeterminesFocalLength()) << "no window";
  EXPECT_TRUE(CheckAlong(WrongMap(kRightAndLeft, Change(0, 0, 0, 0), 0.3, 3)).DeterminesFocalLength());
  CalibrationCheckOptions options;
  options.pixel_sigma_inflation = 500;
  const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, Change(0, 0, 0, 0), 0.3, 3), options);
  ASSERT_GT(check.windows(), 0);
  EXPECT_FALSE(check.DeterminesFocalLength());
  EXPECT_EQ(check.Verdict(WithCorrection()), CalibrationVerdict::kInDoubt);
}

TEST(CalibrationCheck, TellsALensFromAFocalLength) {
  const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, Change(0, 0, 0, 0.015), 0.3, 4));
  const ParameterEstimate distortion = Of(IntrinsicsParameter::kDistortion, check);
  EXPECT_NEAR(distortion.found, 0.015, 2 * distortion.sigma);
  EXPECT_LT(distortion.sigma, 0.007);
  EXPECT_TRUE(check.Contradictions(WithCorrection(0.015)).empty()) << "applied";
}

TEST(CalibrationCheck, FindsAMissingDistortion) {
  // A barrel needs a positive correction.
  for (const double distortion : {0.25, -0.08}) {
    const CalibrationCheck check = CheckAlong(WrongMap(kRightAndLeft, Change(0, 0, 0, distortion), 0.3, 4));
    const std::vector<ParameterEstimate> found = check.Contradictions(WithCorrection());
    ASSERT_EQ(found.size(), 1U) << distortion;
    EXPECT_EQ(found[0].parameter, IntrinsicsParameter::kDistortion);
    EXPECT_NEAR(found[0].found, distortion, 0.03);
  }
}

TEST(CalibrationCheck, SaysNothingWhereTheCalibrationIsRight) {
  for (int seed = 5; seed < 5 + SeedsToTest(6); ++seed) {
    const CalibrationCheck check =
        CheckAlong(WrongMap(kRightAndLeft, Vector::Zero(), 0.3, static_cast<unsigned>(seed)));
    EXPECT_GT(check.windows(), 1);
    EXPECT_TRUE(check.Contradictions(WithCorrection()).empty()) << seed;
    EXPECT_FALSE(check.Readout(WithCorrection())) << seed;
    for (const ParameterEstimate& estimate : check.Parameters(WithCorrection()))
      EXPECT_LT(std::abs(estimate.found - estimate.given), 2.5 * estimate.sigma) << seed;
  }
}

// With derivatives at the measured pixels it is 3 % too long here.
TEST(CalibrationCheck, NoiseDoesNotBiasTheFocalLength) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  double sum = 0;
  int drives = 0;
  for (const unsigned seed : {11U, 12U, 13U, 14U}) {
    sum += CheckAlong(WrongMap(kRightAndLeft, Vector::Zero(), 0.5, seed)).Estimate().change[0];
    ++drives;
  }
  EXPECT_NEAR(sum / drives, 0, 0.004);
}

// The pixels of a camera whose file lacks this correction.
void Distort(const Vector& lens, Map& map) {
  for (Landmark& landmark : map.landmarks)
    for (LandmarkObservation& seen : landmark.observations) {
      const Eigen::Vector2d ideal = seen.pixel;
      for (int round = 0; round < 20; ++round) seen.pixel += ideal - Correct(map.camera, lens, seen.pixel)->pixel;
    }
}

TEST(CalibrationCheck, HigherTermsOfTheLensAreNoFocalLength) {
  for (int seed = 16; seed < 16 + SeedsToTest(2); ++seed) {
    Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.15, static_cast<unsigned>(seed));
    // A camera whose file lacks 0.03 r^2 - 0.03 r^4.
    Vector lens = Change(0, 0, 0, 0.03);
    lens[IntrinsicsChange::kCorrection4] = -0.03;
    Distort(lens, map);
    const CalibrationCheck check = CheckAlong(map);
    EXPECT_NEAR(check.Estimate().change[IntrinsicsChange::kLogFocal], 0, 0.006) << seed;
    const double applied = Of(IntrinsicsParameter::kDistortion, check).found;
    EXPECT_TRUE(check.Contradictions(WithCorrection(applied)).empty()) << seed;
    CalibrationCheckOptions only_square;
    only_square.higher_prior_sigma = 0;
    EXPECT_GT(CheckAlong(map, only_square).Estimate().change[IntrinsicsChange::kLogFocal], 0.03) << seed;
  }
}

TEST(CalibrationCheck, ADistortionCountsByWhatItDoesInTheImage) {
  const auto distortion_of = [](double r2, double r4) {
    Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.15, 18);
    Vector lens = Change(0, 0, 0, r2);
    lens[IntrinsicsChange::kCorrection4] = r4;
    Distort(lens, map);
    const CalibrationCheck check = CheckAlong(map);
    EXPECT_GT(check.windows(), 0);
    const ParameterEstimate distortion = Of(IntrinsicsParameter::kDistortion, check);
    // Of the two, that in r^4 alone is ten sigmas; the others cancel to two or three.
    if (r2 == 0) {
      EXPECT_EQ(check.Contradictions(WithCorrection()).size(), 1U);
    }
    return distortion;
  };
  // All in r^4, and two terms that cancel.
  const ParameterEstimate fourth = distortion_of(0, 0.15);
  EXPECT_NEAR(fourth.found, 0.096, 0.02);
  const ParameterEstimate opposite = distortion_of(0.05, -0.1);
  EXPECT_NEAR(opposite.found, -0.014, 0.02);
}

// What all windows get wrong alike is part of sigma, and one window has its own part.
TEST(CalibrationCheck, OneWindowIsAsUncertainAsAWindowMayBe) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 5);
  CalibrationCheckOptions options;
  options.max_windows = 1;
  options.focal_prior_sigma = 10;
  const CalibrationCheck check = CheckAlong(map, options);
  ASSERT_EQ(check.windows(), 1);
  const double sigma = std::sqrt(check.Estimate().covariance(IntrinsicsChange::kLogFocal, IntrinsicsChange::kLogFocal));
  EXPECT_GT(sigma, std::hypot(options.focal_window_sigma, options.focal_model_sigma));
}

TEST(CalibrationCheck, AStreetDoesNotTell) {
  const CalibrationCheck check = CheckAlong(WrongMap(kStreet, Change(0.14, 0, 0, 0), 0.3, 11));
  EXPECT_EQ(check.windows(), 0);
  EXPECT_TRUE(check.Contradictions(WithCorrection()).empty());
  const ParameterEstimate focal = Of(IntrinsicsParameter::kFocalLength, check);
  EXPECT_EQ(focal.found, focal.given);
  EXPECT_NEAR(focal.sigma / focal.given, CalibrationCheckOptions().focal_prior_sigma, 1e-9);
}

TEST(CalibrationCheck, DoesNotLookAcrossAGap) {
  Map map = WrongMap(kRightAndLeft, Change(0.14, 0, 0, 0), 0.3, 12);
  for (int k = 4; k < CountKeyframes(map); k += 5) map.keyframes[k].after_gap = true;
  EXPECT_EQ(CheckAlong(map).windows(), 0);
}

TEST(CalibrationCheck, PixelsThatAreCorrectedAlreadySayTheSame) {
  const Map raw = WrongMap(kRightAndLeft, Change(0, 0, 0, 0.01), 0.3, 13);
  Map corrected = raw;
  corrected.camera.radial_correction = 0.01;
  for (Landmark& landmark : corrected.landmarks)
    for (LandmarkObservation& seen : landmark.observations)
      seen.pixel = CorrectRadially(corrected.camera.pinhole, 0.01, seen.pixel);
  CalibrationCheck from_raw({}, raw.camera.pinhole);
  CalibrationCheck from_corrected({}, corrected.camera.pinhole);
  ASSERT_TRUE(from_raw.Observe(raw));
  ASSERT_TRUE(from_corrected.Observe(corrected));
  const IntrinsicsEstimate one = from_raw.Estimate();
  const IntrinsicsEstimate other = from_corrected.Estimate();
  const Vector sigmas = one.covariance.diagonal().cwiseSqrt();
  // The search ends within a part of a standard deviation of the minimum, from either side.
  EXPECT_LT(((one.change - other.change).array() / sigmas.array()).abs().maxCoeff(), 0.002);
}

TEST(CalibrationCheck, ANumberThatIsNoneTellsNothing) {
  Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 14);
  for (const KeyframeObservation& seen : map.keyframes.back().observations)
    map.landmarks[seen.landmark].position.x() = std::nan("");
  CalibrationCheck check({}, map.camera.pinhole);
  EXPECT_FALSE(check.Observe(map));
  EXPECT_EQ(check.windows(), 0);
}

TEST(CalibrationCheck, ThePriorHasItsMeanAtTheExpectedChange) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 1);
  const Vector expected = Change(0.05, 4, -3, 0);
  CalibrationCheckOptions options;
  CalibrationCheck unread(options, map.camera.pinhole, expected);
  EXPECT_FALSE(unread.Observe(MapUpTo(1, map)));
  EXPECT_EQ(unread.Estimate().change, expected);
  EXPECT_NEAR(Of(IntrinsicsParameter::kFocalLength, unread).found, std::exp(0.05) * map.camera.pinhole.fx, 1e-9);
  EXPECT_EQ(unread.observed_radius(), 0);
  // So sure of the focal length that the images do not count.
  options.focal_prior_sigma = 1e-5;
  const CalibrationCheck check = CheckAlong(map, options, expected);
  ASSERT_GT(check.windows(), 0);
  EXPECT_NEAR(check.Estimate().change[IntrinsicsChange::kLogFocal], 0.05, 1e-3);
  EXPECT_GT(check.observed_radius(), map.camera.pinhole.cx / 2);
  EXPECT_LT(check.observed_radius(), std::hypot(map.camera.pinhole.cx, map.camera.pinhole.cy) + 20);
}

TEST(CalibrationCheck, AnAngleIsMorePixelsAlongTheLongerFocalLength) {
  Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 1);
  map.camera.pinhole.fy = 1.25 * map.camera.pinhole.fx;
  CalibrationCheck unread({}, map.camera.pinhole);
  EXPECT_FALSE(unread.Observe(MapUpTo(1, map)));
  EXPECT_NEAR(Of(IntrinsicsParameter::kCentreY, unread).sigma, 1.25 * Of(IntrinsicsParameter::kCentreX, unread).sigma,
              1e-9);
}

TEST(CalibrationCheck, CanBeSwitchedOff) {
  CalibrationCheckOptions options;
  options.enabled = false;
  EXPECT_EQ(CheckAlong(WrongMap(kRightAndLeft, Change(0.14, 0, 0, 0), 0.3, 15), options).windows(), 0);
}

}  // namespace
}  // namespace turnscale
