// SPDX-License-Identifier: MIT
#include "turnscale/mapping/row_direction.h"

#include <optional>

#include <gtest/gtest.h>

#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_calibration.h"
#include "turnscale/mapping/test_intrinsics.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

// After so many windows, which follow one another along the drive.
RowDirectionChoice TestedOn(const Map& map, const CalibrationCheckOptions& options = {}, int windows = 6) {
  const IntrinsicsPrior prior = PriorOf(options, map.camera.pinhole, Vector::Zero(), std::nullopt);
  RowDirectionChoice test;
  WindowReadings along;
  for (int i = 0; i < windows; ++i) {
    const IntrinsicsEstimate known = EstimateIntrinsics(options, prior, EvidenceOf(along));
    IntrinsicsProblem window = WindowFrom(2 + 6 * i, map, options);
    if (!along.empty()) window.Change(known.change);
    EXPECT_TRUE(AddReading(options, prior, known, ReadingPlace::kLast, window, along)) << i;
    test.Update(options, prior, along);
  }
  return test;
}

// Of a shutter that reads from the first row or column to the last one.
Map RollingMap(bool reads_columns) {
  Vector error = Vector::Zero();
  error[IntrinsicsChange::kReadout] = -0.025;
  return WrongMap(kRightAndLeft, error, 0.3, 4, Eigen::Quaterniond::Identity(), reads_columns);
}

TEST(RowDirection, IsThatOfTheSensor) {
  const RowDirectionChoice columns = TestedOn(RollingMap(true));
  EXPECT_EQ(columns.direction(), RowDirection::kAcross);
  EXPECT_GT(columns.across().size(), 2U);
  EXPECT_EQ(TestedOn(RollingMap(false)).direction(), RowDirection::kAlong);
}

TEST(RowDirection, IsNotTestedWhereNothingIsUnexpected) {
  const RowDirectionChoice test = TestedOn(WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 5));
  EXPECT_EQ(test.direction(), RowDirection::kAlong);
  EXPECT_TRUE(test.across().empty());
}

TEST(RowDirection, AnotherPrincipalPointIsNoReadoutOfColumns) {
  EXPECT_EQ(TestedOn(WrongMap(kRightAndLeft, Change(0, 40, 0, 0), 0.3, 4)).direction(), RowDirection::kAlong);
}

TEST(RowDirection, IsNotTestedWithoutTheAspect) {
  CalibrationCheckOptions options;
  options.aspect_prior_sigma = 0;
  const RowDirectionChoice test = TestedOn(RollingMap(true), options);
  EXPECT_EQ(test.direction(), RowDirection::kAlong);
  EXPECT_TRUE(test.across().empty());
}

TEST(RowDirection, IsOpenUntilOneIsClearlyBetter) {
  CalibrationCheckOptions options;
  options.significance = 8;
  options.pixel_sigma_inflation = 14;
  const Map map = RollingMap(true);
  const RowDirectionChoice test = TestedOn(map, options, 4);
  EXPECT_EQ(test.direction(), RowDirection::kOpen);
  EXPECT_FALSE(test.across().empty());
  EXPECT_EQ(TestedOn(map, options, 6).direction(), RowDirection::kAcross);
}

}  // namespace
}  // namespace turnscale
