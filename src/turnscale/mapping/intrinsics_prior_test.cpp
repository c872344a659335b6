// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_prior.h"

#include <cmath>
#include <optional>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

const Pinhole kWide = {700, 875, 600, 180};

TEST(IntrinsicsPrior, AnAngleIsMorePixelsAlongTheLongerFocalLength) {
  const Eigen::Vector2d shift = CentreShift(kWide, 0.5);
  EXPECT_NEAR(shift.x(), 700 * 0.5 / kDegreesPerRadian, 1e-9);
  EXPECT_NEAR(shift.y(), 1.25 * shift.x(), 1e-9);
}

TEST(IntrinsicsPrior, IsAsWideAsTheOptionsSay) {
  CalibrationCheckOptions options;
  options.focal_prior_sigma = 0.2;
  options.aspect_prior_sigma = 0;
  const Vector expected = Vector::LinSpaced(0.01, 0.08);
  const IntrinsicsPrior prior = PriorOf(options, kWide, expected, std::nullopt);
  EXPECT_EQ(prior.given, kWide);
  EXPECT_EQ(prior.mean, expected);
  EXPECT_FALSE(prior.has_readout);
  const Vector sigmas = prior.covariance.diagonal().cwiseSqrt();
  EXPECT_NEAR(sigmas[IntrinsicsChange::kLogFocal], 0.2, 1e-12);
  EXPECT_NEAR(sigmas[IntrinsicsChange::kCentreY], CentreShift(kWide, options.centre_prior_sigma_deg).y(), 1e-9);
  EXPECT_NEAR(sigmas[IntrinsicsChange::kCorrection], options.correction_prior_sigma, 1e-12);
  EXPECT_NEAR(sigmas[IntrinsicsChange::kCorrection4], options.higher_prior_sigma, 1e-12);
  EXPECT_NEAR(sigmas[IntrinsicsChange::kCorrection6], options.higher_prior_sigma, 1e-12);
  EXPECT_GT(sigmas[IntrinsicsChange::kLogAspect], 0) << "not estimated: it has an inverse all the same";
  EXPECT_NEAR(sigmas[IntrinsicsChange::kReadout], options.readout_prior_sigma, 1e-12);
}

TEST(IntrinsicsPrior, AReadoutThatIsKnownTakesThePlaceOfTheExpectedOne) {
  const Vector expected = Vector::Constant(0.01);
  const IntrinsicsPrior prior = PriorOf({}, kWide, expected, GivenReadout{0.03, 0.002});
  EXPECT_TRUE(prior.has_readout);
  EXPECT_EQ(prior.mean[IntrinsicsChange::kReadout], 0.03);
  EXPECT_EQ(prior.mean.head<IntrinsicsChange::kReadout>(), expected.head<IntrinsicsChange::kReadout>());
  EXPECT_NEAR(std::sqrt(prior.covariance(IntrinsicsChange::kReadout, IntrinsicsChange::kReadout)), 0.002, 1e-12);
  EXPECT_TRUE(PriorOf({}, kWide, expected, GivenReadout{0.03, 0}).covariance.inverse().allFinite()) << "exact";
}

}  // namespace
}  // namespace turnscale
