// SPDX-License-Identifier: MIT
#include "turnscale/odometry/self_calibration.h"

#include <limits>
#include <optional>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

TEST(SelfCalibration, OptionsNameTheFieldThatMakesNoSense) {
  using Options = SelfCalibrationOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.windows = 0; }), "windows");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.first_windows = 0; }), "first_windows");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.first_min_turn_deg = 0; }), "first_min_turn_deg");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_passes = 0; }), "max_passes");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_interval = -0.01; }), "min_interval");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_interval = 0; }), "") << "all images";
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.converged = 0; }), "converged");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.converged_sigmas = -1; }), "converged_sigmas");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.converged_sigmas = 0; }), "") << "rays alone decide";
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.focal_prior_sigma = 0; }), "focal_prior_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.correction_prior_sigma = 0; }), "correction_prior_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.higher_prior_sigma = -1; }), "higher_prior_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.higher_prior_sigma = 0; }), "") << "one term only";
}

TEST(SelfCalibration, NumbersThatAreNoneAreRefused) {
  using Options = SelfCalibrationOptions;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(RefusedField<Options>([](auto& o) { o.first_min_turn_deg = kNone; }), "");
  EXPECT_NE(RefusedField<Options>([](auto& o) { o.min_interval = kNone; }), "");
  EXPECT_NE(RefusedField<Options>([](auto& o) { o.converged = kNone; }), "");
  EXPECT_NE(RefusedField<Options>([](auto& o) { o.converged_sigmas = kNone; }), "");
  EXPECT_NE(RefusedField<Options>([](auto& o) { o.focal_prior_sigma = kNone; }), "");
  EXPECT_NE(RefusedField<Options>([](auto& o) { o.correction_prior_sigma = kNone; }), "");
  EXPECT_NE(RefusedField<Options>([](auto& o) { o.higher_prior_sigma = kNone; }), "");
}

TEST(SelfCalibration, OptionsAreCheckedBeforeTheDriveIsOpened) {
  int opened = 0;
  const OpenDrive open = [&](std::optional<double>) -> ImageStream {
    ++opened;
    return [] { return std::nullopt; };
  };
  const StartCamera start = {.camera = CameraOfView(70, 640, 360)};
  EXPECT_THROW(CalibrateFromDrive({.windows = 0}, {}, start, open), InputError);
  OdometryOptions odometry;
  odometry.repeats.max_motion = 0;
  EXPECT_THROW(CalibrateFromDrive({}, odometry, start, open), InputError);
  EXPECT_EQ(opened, 0);
}

TEST(SelfCalibration, OtherFieldsOfViewAreTriedIfNothingIsTrackedWithAnAssumedCamera) {
  const StartCamera assumed = {.camera = CameraOfView(70, 64, 36)};
  StartCamera given = assumed;
  given.assumed = false;
  for (const StartCamera& start : {given, assumed}) {
    int opened = 0;
    const OpenDrive black = [&](std::optional<double> from) -> ImageStream {
      EXPECT_FALSE(from) << "from the beginning";
      ++opened;
      return [image = 0]() mutable -> std::optional<TimedImage> {
        if (image == 3) return std::nullopt;
        return TimedImage{cv::Mat::zeros(36, 64, CV_8UC1), 0.1 * image++};
      };
    };
    EXPECT_FALSE(CalibrateFromDrive({}, {}, start, black));
    EXPECT_EQ(opened, start.assumed ? 3 : 1);
    const SelfCalibrationOptions options = {.max_passes = 6};
    EXPECT_EQ(MostPasses(options, start.assumed), options.max_passes + opened - 1);
  }
}

}  // namespace
}  // namespace turnscale
