// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_estimate.h"

#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_evidence.h"
#include "turnscale/mapping/test_intrinsics.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;
using Matrix = IntrinsicsChange::Matrix;

IntrinsicsPrior UsualPrior() { return PriorOf({}, kTestPinhole, Vector::Zero(), std::nullopt); }

TEST(IntrinsicsEstimate, IsThePriorWithoutWindows) {
  const IntrinsicsPrior prior = PriorOf({}, kTestPinhole, Change(0.05, 4, -3, 0), std::nullopt);
  const IntrinsicsEstimate estimate = EstimateIntrinsics({}, prior, {});
  EXPECT_EQ(estimate.change, prior.mean);
  EXPECT_EQ(estimate.covariance, prior.covariance);
  EXPECT_TRUE(estimate.Holds(IntrinsicsChange::kLogAspect));
  EXPECT_TRUE(estimate.Holds(IntrinsicsChange::kReadout));
  EXPECT_FALSE(estimate.Holds(IntrinsicsChange::kLogFocal));
}

TEST(IntrinsicsEstimate, ErrorsAreAsLargeAsItsSigmas) {
  CalibrationCheckOptions options;
  options.focal_model_sigma = options.centre_model_sigma_deg = options.correction_model_sigma = 0;
  const Vector truth = Change(0.05, 6, -4, 0.02);
  Vector squares = Vector::Zero();
  constexpr int kDrives = 200;
  for (unsigned seed = 1; seed <= kDrives; ++seed) {
    const IntrinsicsEstimate estimate =
        CombineWindows(options, UsualPrior(), EvidenceAround(truth, 8, seed), {IntrinsicsChange::kReadout});
    const Vector off = (estimate.change - truth).cwiseQuotient(estimate.covariance.diagonal().cwiseSqrt());
    squares += off.cwiseAbs2() / kDrives;
  }
  for (const IntrinsicsChange::Entry entry :
       {IntrinsicsChange::kLogFocal, IntrinsicsChange::kCentreX, IntrinsicsChange::kCorrection}) {
    EXPECT_GT(squares[entry], 0.5) << entry;
    EXPECT_LT(squares[entry], 1.5) << entry;
  }
}

TEST(IntrinsicsEstimate, AWindowThatIsWrongHardlyCounts) {
  const Vector truth = Change(0.05, 6, -4, 0.02);
  std::vector<WindowEvidence> windows = EvidenceAround(truth, 8, 3);
  const IntrinsicsEntries held = {IntrinsicsChange::kReadout};
  const IntrinsicsEstimate without = CombineWindows({}, UsualPrior(), windows, held);
  windows.push_back(EvidenceAt(truth + Change(0.2, 0, 0, 0)));
  const IntrinsicsEstimate with = CombineWindows({}, UsualPrior(), windows, held);
  EXPECT_NEAR(with.change[IntrinsicsChange::kLogFocal], without.change[IntrinsicsChange::kLogFocal], 0.002);
}

TEST(IntrinsicsEstimate, WindowsThatScatterMoreThanTheySayWidenTheSigmas) {
  const auto sigma = [](double scatter) {
    std::vector<WindowEvidence> windows;
    for (const double side : {-1, 1, -1, 1}) windows.push_back(EvidenceAt(Change(side * scatter, 0, 0, 0)));
    return std::sqrt(CombineWindows({}, UsualPrior(), windows, {}).covariance(0, 0));
  };
  EXPECT_LT(sigma(0.001), 1.01 * sigma(0)) << "less is chance";
  EXPECT_GT(sigma(0.03), 1.3 * sigma(0));
}

TEST(IntrinsicsEstimate, WhatAllWindowsGetWrongIsPartOfTheSigmas) {
  const std::vector<WindowEvidence> windows(50, EvidenceAt(Vector::Zero()));
  const IntrinsicsEstimate estimate = EstimateIntrinsics({}, UsualPrior(), windows);
  EXPECT_GT(std::sqrt(estimate.covariance(0, 0)), CalibrationCheckOptions().focal_model_sigma);
  EXPECT_LT(std::sqrt(estimate.covariance(0, 0)), 1.01 * CalibrationCheckOptions().focal_model_sigma);
}

// The conditional distribution of the others.
TEST(IntrinsicsEstimate, WhatIsHeldIsAtThePriorsMean) {
  Vector expected = Vector::Zero();
  expected[IntrinsicsChange::kLogAspect] = 0.1;
  IntrinsicsPrior prior = PriorOf({}, kTestPinhole, expected, std::nullopt);
  prior.covariance *= 1e8;
  const Vector minimum = Change(0.02, 3, -2, 0.01);
  const IntrinsicsEstimate held = CombineWindows({}, prior, {EvidenceAt(minimum)}, {IntrinsicsChange::kLogAspect});
  EXPECT_NEAR(held.change[IntrinsicsChange::kLogAspect], 0.1, 1e-9);
  const Matrix covariance = CovarianceOfWindow();
  constexpr int kEntry = IntrinsicsChange::kLogAspect;
  const Vector shift = covariance.col(kEntry) / covariance(kEntry, kEntry) * (0.1 - minimum[kEntry]);
  EXPECT_NEAR(held.change[IntrinsicsChange::kLogFocal], minimum[0] + shift[0], 1e-6);
  EXPECT_NEAR(held.change[IntrinsicsChange::kReadout], minimum[7] + shift[7], 1e-6);
}

TEST(IntrinsicsEstimate, AspectAndReadoutAreEstimatedOnceTheyAreContradicted) {
  const auto held = [](IntrinsicsChange::Entry entry, double off, const IntrinsicsPrior& prior) {
    return EntriesToHold({}, prior, std::vector<WindowEvidence>(3, EvidenceAt(off * Vector::Unit(entry))));
  };
  using Entries = IntrinsicsEntries;
  constexpr auto kAspect = IntrinsicsChange::kLogAspect;
  constexpr auto kReadout = IntrinsicsChange::kReadout;
  EXPECT_EQ(held(kAspect, 0, UsualPrior()), (Entries{kAspect, kReadout}));
  EXPECT_EQ(held(kAspect, 0.25, UsualPrior()), (Entries{kReadout}));
  EXPECT_EQ(held(kReadout, 0.025, UsualPrior()), (Entries{kAspect}));
  EXPECT_EQ(held(kReadout, 0.003, UsualPrior()), (Entries{kAspect, kReadout})) << "too little to be reported";
  const IntrinsicsPrior known = PriorOf({}, kTestPinhole, Vector::Zero(), GivenReadout{0, 0.001});
  EXPECT_EQ(held(kReadout, 0, known), (Entries{kAspect})) << "known: always estimated";
}

TEST(IntrinsicsEstimate, AnAspectThatDoesNotOccurIsHeld) {
  CalibrationCheckOptions options;
  options.aspect_prior_sigma = 10;
  const IntrinsicsPrior prior = PriorOf(options, kTestPinhole, Vector::Zero(), std::nullopt);
  const auto estimate = [&](double aspect) {
    return EstimateIntrinsics(options, prior, {EvidenceAt(aspect * Vector::Unit(IntrinsicsChange::kLogAspect))});
  };
  EXPECT_FALSE(estimate(std::log(2)).Holds(IntrinsicsChange::kLogAspect));
  EXPECT_TRUE(estimate(std::log(4)).Holds(IntrinsicsChange::kLogAspect));
}

TEST(IntrinsicsEstimate, AWindowsOwnErrorsAddToItsVariances) {
  const CalibrationCheckOptions options;
  const Matrix noise = CovarianceOfWindow();
  const Vector minimum = Change(0.02, 3, -2, 0.01);
  const WindowEvidence evidence = WithWindowErrors(options, kTestPinhole, noise.inverse(), noise.inverse() * minimum);
  const Matrix covariance = evidence.information.inverse();
  EXPECT_NEAR(std::sqrt(covariance(0, 0)), std::hypot(std::sqrt(noise(0, 0)), options.focal_window_sigma), 1e-9);
  EXPECT_NEAR(covariance(0, 1), noise(0, 1), 1e-9);
  EXPECT_NEAR((covariance * evidence.weighted_minimum - minimum).cwiseAbs().maxCoeff(), 0, 1e-9);
  EXPECT_TRUE(WithWindowErrors(options, kTestPinhole, Matrix::Zero(), Vector::Zero()).information.isZero());
}

TEST(IntrinsicsEstimate, ADistanceIsInSigmasOfTheWindow) {
  const Vector minimum = Change(0.02, 3, -2, 0.01);
  EXPECT_NEAR(SquaredDistance(EvidenceAt(minimum), minimum), 0, 1e-9);
  const Vector sigma = SigmasOfWindow()[0] * Vector::Unit(0);
  const double expected = sigma.dot(CovarianceOfWindow().inverse() * sigma);
  EXPECT_NEAR(SquaredDistance(EvidenceAt(minimum), minimum + 2 * sigma), 4 * expected, 1e-6);
  EXPECT_EQ(MisfitOfDistance({}, {}, 0), 0);
  EXPECT_LT(MisfitOfDistance({}, {}, 1e4), 1e3) << "a window may be wrong";
}

}  // namespace
}  // namespace turnscale
