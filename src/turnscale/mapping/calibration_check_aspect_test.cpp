// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/mapping/calibration_verdict.h"
#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/mapping/test_calibration.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

TEST(CalibrationCheckAspect, FindsPixelsThatAreNotSquare) {
  for (const double aspect : {0.5, 0.75, 1.33, 2.0}) {
    const CalibrationCheck check = CheckAlong(SqueezedMap(aspect, 4));
    const ParameterEstimate found = Of(IntrinsicsParameter::kPixelAspect, check);
    EXPECT_NEAR(found.given, 1 / aspect, 1e-9);
    EXPECT_NEAR(found.found, 1, 2 * found.sigma) << aspect;
    EXPECT_LT(found.sigma, 0.08) << aspect;
    EXPECT_TRUE(Contradicts({}, kTestPinhole, found)) << aspect;
    // The others are right, and so are their estimates.
    const std::vector<ParameterEstimate> contradictions = check.Contradictions(WithCorrection());
    ASSERT_EQ(contradictions.size(), 1U) << aspect;
    EXPECT_EQ(contradictions[0].parameter, IntrinsicsParameter::kPixelAspect);
    const ParameterEstimate y = Of(IntrinsicsParameter::kCentreY, check);
    EXPECT_NEAR(y.found, 185, 2 * y.sigma) << aspect;
    const ParameterEstimate focal = Of(IntrinsicsParameter::kFocalLength, check);
    EXPECT_NEAR(focal.found, 718, focal.sigma) << aspect;
  }
}

TEST(CalibrationCheckAspect, ALevelTurnDoesNotShowThePixelsAspect) {
  const CalibrationCheck level = CheckAlong(SqueezedMap(1 / 1.22, 4, Eigen::Quaterniond::Identity()));
  const ParameterEstimate found = Of(IntrinsicsParameter::kPixelAspect, level);
  EXPECT_GT(found.sigma, 0.1);
  EXPECT_FALSE(Contradicts({}, kTestPinhole, found));
  EXPECT_TRUE(level.Estimate().Holds(IntrinsicsChange::kLogAspect));
}

bool HasAspect(const std::vector<ParameterEstimate>& parameters) {
  return std::ranges::find(parameters, IntrinsicsParameter::kPixelAspect, &ParameterEstimate::parameter) !=
         parameters.end();
}

TEST(CalibrationCheckAspect, AnAspectCanBeLeftOut) {
  CalibrationCheckOptions options;
  options.aspect_prior_sigma = 0;
  const CalibrationCheck check = CheckAlong(SqueezedMap(0.75, 4), options);
  const IntrinsicsEstimate estimate = check.Estimate();
  EXPECT_TRUE(estimate.Holds(IntrinsicsChange::kLogAspect));
  EXPECT_EQ(estimate.change[IntrinsicsChange::kLogAspect], 0);
  EXPECT_FALSE(HasAspect(check.Parameters(WithCorrection())));
  EXPECT_FALSE(HasAspect(check.Contradictions(WithCorrection())));
}

TEST(CalibrationCheckAspect, AnAspectThatDoesNotOccurIsNotReported) {
  // So far from what is expected.
  const auto check_of = [](double expected_aspect) {
    CalibrationCheckOptions options;
    options.aspect_prior_sigma = 10;
    Vector expected = Vector::Zero();
    expected[IntrinsicsChange::kLogAspect] = std::log(expected_aspect);
    return CheckAlong(SqueezedMap(0.75, 4), options, expected);
  };
  EXPECT_TRUE(HasAspect(check_of(1).Contradictions(WithCorrection())));
  const CalibrationCheck far = check_of(4);
  EXPECT_TRUE(far.Estimate().Holds(IntrinsicsChange::kLogAspect));
  EXPECT_FALSE(HasAspect(far.Parameters(WithCorrection())));
  EXPECT_FALSE(HasAspect(far.Contradictions(WithCorrection())));
}

// As in passes over a drive: what a pass has changed goes on only as long as the images ask for it.
TEST(CalibrationCheckAspect, TheAspectIsTestedAgainstWhatIsExpected) {
  const double wrong = std::log(1.25);
  Vector expected = Vector::Zero();
  const auto change_of = [&](const Map& map) { return CheckAlong(map, {}, expected).Estimate(); };
  // The pass before has found the aspect.
  expected[IntrinsicsChange::kLogAspect] = -wrong;
  const IntrinsicsEstimate right = change_of(WrongMap(kRightAndLeft, Vector::Zero(), 0.3, 4, kPitched));
  EXPECT_FALSE(right.Holds(IntrinsicsChange::kLogAspect));
  EXPECT_NEAR(right.change[IntrinsicsChange::kLogAspect], 0, 0.05);
  // It has taken something else for one.
  const IntrinsicsEstimate back = change_of(SqueezedMap(1 / 1.25, 4));
  EXPECT_TRUE(back.Holds(IntrinsicsChange::kLogAspect));
  EXPECT_NEAR(back.change[IntrinsicsChange::kLogAspect], -wrong, 1e-12);
  EXPECT_NEAR(back.change[IntrinsicsChange::kLogFocal], 0, 0.01);
  EXPECT_NEAR(back.change[IntrinsicsChange::kCentreY], 0, 8);
}

}  // namespace
}  // namespace turnscale
