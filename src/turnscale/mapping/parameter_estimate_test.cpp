// SPDX-License-Identifier: MIT
#include "turnscale/mapping/parameter_estimate.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_calibration.h"
#include "turnscale/mapping/test_evidence.h"
#include "turnscale/mapping/test_intrinsics.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

IntrinsicsEstimate EstimateOf(const Vector& change) {
  IntrinsicsEstimate estimate;
  estimate.change = change;
  estimate.covariance = CovarianceOfWindow();
  return estimate;
}

TEST(ParameterEstimate, AChangeIsStatedInPixels) {
  const std::vector<ParameterEstimate> parameters =
      PinholeAndDistortion({}, kTestPinhole, WithCorrection(), EstimateOf(Change(std::log(1.1), 5, -4, 0.02)));
  ASSERT_EQ(parameters.size(), 4U);
  const ParameterEstimate focal = Of(IntrinsicsParameter::kFocalLength, parameters);
  EXPECT_EQ(focal.given, 700);
  EXPECT_NEAR(focal.found, 770, 1e-9);
  EXPECT_NEAR(focal.sigma, 770 * SigmasOfWindow()[IntrinsicsChange::kLogFocal], 1e-9);
  EXPECT_NEAR(Of(IntrinsicsParameter::kCentreX, parameters).found, 605, 1e-9);
  EXPECT_NEAR(Of(IntrinsicsParameter::kCentreY, parameters).found, 176, 1e-9);
  EXPECT_NEAR(Of(IntrinsicsParameter::kCentreY, parameters).sigma, SigmasOfWindow()[IntrinsicsChange::kCentreY], 1e-9);
  EXPECT_NEAR(Of(IntrinsicsParameter::kDistortion, parameters).found, 0.02, 1e-12);
}

// Least squares of c r^3 over the disc up to the corner, for shifts by r^5.
TEST(ParameterEstimate, ADistortionIsTheTermInTheSquareThatMovesPixelsMostAlike) {
  Vector change = Vector::Zero();
  change[IntrinsicsChange::kCorrection4] = 0.1;
  const auto found = [&](const CalibrationCheckOptions& options) {
    return Of(IntrinsicsParameter::kDistortion,
              PinholeAndDistortion(options, kTestPinhole, WithCorrection(), EstimateOf(change)))
        .found;
  };
  double products = 0;
  double squares = 0;
  const double corner = std::hypot(600.0 / 700, 180.0 / 700);
  constexpr int kSteps = 10000;
  for (int i = 0; i < kSteps; ++i) {
    const double r = corner * (i + 0.5) / kSteps;
    products += r * std::pow(r, 3) * 0.1 * std::pow(r, 5);
    squares += r * std::pow(r, 6);
  }
  EXPECT_NEAR(found({}), products / squares, 1e-7);
  CalibrationCheckOptions only_square;
  only_square.higher_prior_sigma = 0;
  EXPECT_EQ(found(only_square), 0);
}

// What is applied is a share of the square of the radius without distortion, what is found one of that in the image.
TEST(ParameterEstimate, WhatIsAppliedIsStatedAsWhatIsFound) {
  const auto given = [&](double correction, double k1) {
    CameraModel camera = WithCorrection(correction);
    camera.lens = LensModel::kRadialTangential;
    camera.distortion[0] = k1;
    return Of(IntrinsicsParameter::kDistortion,
              PinholeAndDistortion({}, camera.pinhole, camera, EstimateOf(Vector::Zero())))
        .given;
  };
  EXPECT_NEAR(given(0.05, 0), 0.05, 1e-12);
  EXPECT_EQ(given(0, -0.2), 0);
  // u^2 = r^2 + 0.4 r^4 + ..., of which r^4 counts 0.8 times the square of the corner's radius, 0.785.
  EXPECT_GT(given(0.05, -0.2), 0.05 * (1 + 0.4 * 0.8 * 0.785));
  EXPECT_LT(given(0.05, -0.2), 0.05 * 1.7);
  EXPECT_LT(given(0.05, 0.2), 0.045);
}

TEST(ParameterEstimate, AnAspectIsARatioOfFocalLengths) {
  const Pinhole given = {700, 770, 600, 180};
  Vector change = Vector::Zero();
  change[IntrinsicsChange::kLogAspect] = -std::log(1.1);
  const ParameterEstimate aspect = PixelAspect(given, EstimateOf(change));
  EXPECT_NEAR(aspect.given, 1.1, 1e-12);
  EXPECT_NEAR(aspect.found, 1, 1e-12);
  EXPECT_NEAR(aspect.sigma, SigmasOfWindow()[IntrinsicsChange::kLogAspect], 1e-12);
}

TEST(ParameterEstimate, WindowsTellAReadoutWhateverIsKnownOfIt) {
  Vector truth = Vector::Zero();
  truth[IntrinsicsChange::kReadout] = 0.02;
  for (const double given : {0.0, 0.02, -0.03, 0.15}) {
    const ParameterEstimate readout =
        ReadoutWithoutPrior({}, kTestPinhole, Vector::Zero(), {given, 0.004}, EvidenceAround(truth, 8, 1));
    EXPECT_EQ(readout.given, given);
    EXPECT_NEAR(readout.found, 0.02, 0.001) << given;
    EXPECT_GT(readout.sigma, 0.004) << "that of the difference";
    EXPECT_LT(readout.sigma, 0.005);
  }
  const ParameterEstimate unread = ReadoutWithoutPrior({}, kTestPinhole, Vector::Zero(), {0.15, 0.004}, {});
  EXPECT_LT(std::abs(unread.found - unread.given), unread.sigma) << "the prior alone contradicts nothing";
}

}  // namespace
}  // namespace turnscale
