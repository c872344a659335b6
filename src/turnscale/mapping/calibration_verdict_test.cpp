// SPDX-License-Identifier: MIT
#include "turnscale/mapping/calibration_verdict.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/mapping/intrinsics_prior.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

using Parameters = std::vector<ParameterEstimate>;

// Off by so many sigmas, and by far more than what is reported.
Parameters OffBySigmas(IntrinsicsParameter parameter, double sigmas) { return {{parameter, 1, 1 + 500 * sigmas, 500}}; }

// With a focal length of this relative standard deviation.
CalibrationVerdict Verdict(const Parameters& parameters, double focal_sigma = 0.01) {
  IntrinsicsEstimate estimate;
  estimate.covariance(IntrinsicsChange::kLogFocal, IntrinsicsChange::kLogFocal) = focal_sigma * focal_sigma;
  return VerdictOn({}, kTestPinhole, parameters, estimate);
}

constexpr IntrinsicsParameter kOfPinholeAndLens[] = {IntrinsicsParameter::kFocalLength, IntrinsicsParameter::kCentreX,
                                                     IntrinsicsParameter::kCentreY, IntrinsicsParameter::kDistortion};

TEST(CalibrationVerdict, DeviationsOfTwoToThreeSigmasAreDoubts) {
  for (const IntrinsicsParameter parameter : kOfPinholeAndLens) {
    const auto count = [&](double sigmas, auto among) {
      return among({}, kTestPinhole, OffBySigmas(parameter, sigmas)).size();
    };
    EXPECT_EQ(count(1.9, DoubtsAmong), 0U);
    EXPECT_EQ(count(2.5, DoubtsAmong), 1U);
    EXPECT_EQ(count(3.1, DoubtsAmong), 0U) << "contradicted";
    EXPECT_EQ(count(2.9, ContradictionsAmong), 0U);
    EXPECT_EQ(count(3.1, ContradictionsAmong), 1U);
    EXPECT_EQ(Verdict(OffBySigmas(parameter, 1.9)), CalibrationVerdict::kNotContradicted);
    EXPECT_EQ(Verdict(OffBySigmas(parameter, -2.5)), CalibrationVerdict::kInDoubt);
    EXPECT_EQ(Verdict(OffBySigmas(parameter, -3.1)), CalibrationVerdict::kContradicted);
  }
}

TEST(CalibrationVerdict, AnErrorTooSmallForAReportLeavesDoubtAllTheSame) {
  const double least = CentreShift(kTestPinhole, CalibrationCheckOptions().min_centre_error_deg).x();
  const Parameters parameters = {{IntrinsicsParameter::kCentreX, 600, 600 + 0.9 * least, 0.1 * least}};
  EXPECT_TRUE(ContradictionsAmong({}, kTestPinhole, parameters).empty());
  EXPECT_TRUE(DoubtsAmong({}, kTestPinhole, parameters).empty());
  EXPECT_EQ(Verdict(parameters), CalibrationVerdict::kInDoubt);
}

TEST(CalibrationVerdict, AReadoutIsNoneOfTheCamera) {
  const Parameters readout = {{IntrinsicsParameter::kReadout, 0.03, 0, 0.001}};
  EXPECT_TRUE(Contradicts({}, kTestPinhole, readout.front()));
  EXPECT_TRUE(ContradictionsAmong({}, kTestPinhole, readout).empty());
  EXPECT_EQ(Verdict(readout), CalibrationVerdict::kNotContradicted);
}

TEST(CalibrationVerdict, AnAspectContradictsButLeavesNoDoubt) {
  const auto off = [](double sigmas) {
    return Parameters{{IntrinsicsParameter::kPixelAspect, 1, 1.2, 1.2 * std::log(1.2) / sigmas}};
  };
  EXPECT_TRUE(DoubtsAmong({}, kTestPinhole, off(2.5)).empty());
  EXPECT_EQ(Verdict(off(2.5)), CalibrationVerdict::kNotContradicted);
  EXPECT_EQ(Verdict(off(3.1)), CalibrationVerdict::kContradicted);
}

// Of a ratio, the sigma is relative, and an error has no bound from below.
TEST(CalibrationVerdict, AnAspectIsAsWrongBelowAsAbove) {
  for (const double ratio : {0.4, 0.5, 0.8, 1.25, 2.0, 2.5}) {
    const double relative = std::abs(std::log(ratio)) / 3;
    const auto contradicts = [&](double sigma) {
      return Contradicts({}, kTestPinhole, {IntrinsicsParameter::kPixelAspect, 1, ratio, sigma * ratio});
    };
    EXPECT_TRUE(contradicts(0.99 * relative)) << ratio;
    EXPECT_FALSE(contradicts(1.01 * relative)) << ratio;
  }
}

TEST(CalibrationVerdict, AFocalLengthThatIsNotDeterminedIsInDoubt) {
  EXPECT_EQ(Verdict({}, 0.049), CalibrationVerdict::kNotContradicted);
  EXPECT_EQ(Verdict({}, 0.051), CalibrationVerdict::kInDoubt);
  EXPECT_EQ(Verdict(OffBySigmas(IntrinsicsParameter::kCentreX, 4), 0.051), CalibrationVerdict::kContradicted);
}

}  // namespace
}  // namespace turnscale
