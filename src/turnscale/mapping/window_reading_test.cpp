// SPDX-License-Identifier: MIT
#include "turnscale/mapping/window_reading.h"

#include <cmath>
#include <cstddef>
#include <optional>

#include <gtest/gtest.h>

#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_calibration.h"
#include "turnscale/mapping/test_intrinsics.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

// In the middle of the first turn.
constexpr int kFirst = 6;

IntrinsicsPrior PriorFor(const Map& map) { return PriorOf({}, map.camera.pinhole, Vector::Zero(), std::nullopt); }

// The mean of prior and window.
Vector MeanWith(const IntrinsicsPrior& prior, const WindowEvidence& evidence) {
  return CombineWindows({}, prior, {evidence}, {IntrinsicsChange::kLogAspect, IntrinsicsChange::kReadout}).change;
}

TEST(WindowReading, EndsAtTheTrueIntrinsics) {
  const Vector error = Change(std::log(1.15), 0, 0, 0.02);
  const Map map = WrongMap(kRightAndLeft, error, 0.1, 2);
  const IntrinsicsPrior prior = PriorFor(map);
  IntrinsicsProblem window = WindowFrom(kFirst, map);
  const std::optional<WindowReading> reading =
      ReadWindow({}, map.camera.pinhole, EstimateIntrinsics({}, prior, {}), window);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->at, window.change());
  EXPECT_NEAR(reading->at[IntrinsicsChange::kLogFocal], -std::log(1.15), 0.02);
  EXPECT_NEAR(MeanWith(prior, reading->evidence)[IntrinsicsChange::kLogFocal], -std::log(1.15), 0.02);
  EXPECT_NEAR(reading->pixel_sigma, 0.1, 0.03);
  EXPECT_EQ(reading->residuals->size(), window.Residuals().size());
  EXPECT_FALSE(reading->window);
}

TEST(WindowReading, WhatIsKnownIsNoPartOfIt) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.1, 2);
  IntrinsicsPrior known = PriorFor(map);
  const auto read = [&](const IntrinsicsPrior& prior) {
    IntrinsicsProblem window = WindowFrom(kFirst, map);
    return ReadWindow({}, map.camera.pinhole, EstimateIntrinsics({}, prior, {}), window);
  };
  const std::optional<WindowReading> wide = read(known);
  known.covariance *= 0.01;
  known.mean = Change(0.06, 0, 0, 0);
  const std::optional<WindowReading> narrow = read(known);
  ASSERT_TRUE(wide && narrow);
  constexpr double kClose = 0.004;
  const double mean = MeanWith(PriorFor(map), wide->evidence)[0];
  EXPECT_NEAR(MeanWith(PriorFor(map), narrow->evidence)[0], mean, kClose);
  EXPECT_GT(std::abs(MeanWith(known, narrow->evidence)[0] - mean), 2 * kClose) << "where it is a part";
}

TEST(WindowReading, TermsThatAreNotEstimatedHaveNoInformation) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.1, 2);
  CalibrationCheckOptions options;
  options.higher_prior_sigma = 0;
  IntrinsicsProblem window = WindowFrom(kFirst, map);
  const std::optional<WindowReading> reading =
      ReadWindow(options, map.camera.pinhole, EstimateIntrinsics(options, PriorFor(map), {}), window);
  ASSERT_TRUE(reading);
  EXPECT_TRUE(reading->own_information.row(IntrinsicsChange::kCorrection4).isZero());
  EXPECT_EQ(window.change()[IntrinsicsChange::kCorrection6], 0);
}

TEST(WindowReading, OnlyTheLatestKeepTheirWindows) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.1, 2);
  const IntrinsicsPrior prior = PriorFor(map);
  const IntrinsicsEstimate known = EstimateIntrinsics({}, prior, {});
  WindowReadings readings;
  constexpr size_t kWindows = 14;
  for (size_t i = 0; i < kWindows; ++i) {
    IntrinsicsProblem window = WindowFrom(kFirst, map);
    ASSERT_TRUE(AddReading({}, prior, known, ReadingPlace::kLast, window, readings));
    EXPECT_EQ(EvidenceOf(readings).size(), i + 1);
    EXPECT_EQ(readings.back().window->change(), readings.back().at);
  }
  EXPECT_FALSE(readings[1].window);
  EXPECT_FALSE(readings[1].residuals);
  EXPECT_TRUE(readings[2].window);
  EXPECT_TRUE(readings[2].residuals);
}

TEST(WindowReading, AnEarlierWindowComesFirst) {
  const Map map = WrongMap(kRightAndLeft, Vector::Zero(), 0.1, 2);
  const IntrinsicsPrior prior = PriorFor(map);
  WindowReadings readings;
  for (const int first : {kFirst, 2}) {
    IntrinsicsProblem window = WindowFrom(first, map);
    ASSERT_TRUE(AddReading({}, prior, EstimateIntrinsics({}, prior, EvidenceOf(readings)), ReadingPlace::kFirst, window,
                           readings));
  }
  ASSERT_EQ(readings.size(), 2U);
  const IntrinsicsProblem later = WindowFrom(kFirst, map);
  EXPECT_EQ(readings[1].residuals->size(), later.Residuals().size());
  EXPECT_NE(readings[0].residuals->size(), later.Residuals().size());
}

// A linear model of the first window would not lead there.
TEST(WindowReading, WindowsAreLinearisedAnewWhereTheAspectBecomesFree) {
  const double aspect = std::log(0.75);
  const Map map = SqueezedMap(0.75, 4);
  const IntrinsicsPrior prior = PriorFor(map);
  WindowReadings readings;
  for (int first = 0; first + CalibrationCheckOptions().window <= CountKeyframes(map); first += 5) {
    IntrinsicsProblem window = WindowFrom(first, map);
    const IntrinsicsEstimate known = EstimateIntrinsics({}, prior, EvidenceOf(readings));
    const bool was_held = known.Holds(IntrinsicsChange::kLogAspect);
    ASSERT_TRUE(AddReading({}, prior, known, ReadingPlace::kLast, window, readings));
    if (EstimateIntrinsics({}, prior, EvidenceOf(readings)).Holds(IntrinsicsChange::kLogAspect)) continue;
    EXPECT_TRUE(was_held);
    for (const WindowReading& reading : readings) EXPECT_NEAR(reading.evidence.aspect, aspect, 0.1);
    return;
  }
  FAIL() << "the aspect is never shown";
}

}  // namespace
}  // namespace turnscale
