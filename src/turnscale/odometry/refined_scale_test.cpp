// SPDX-License-Identifier: MIT
#include "turnscale/odometry/refined_scale.h"

#include <cmath>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

ParameterEstimate Off(IntrinsicsParameter parameter, double off) {
  ParameterEstimate estimate;
  estimate.parameter = parameter;
  estimate.given = 500;
  estimate.found = 500 + off;
  return estimate;
}

TEST(WidenForCalibration, AddsWhatEachContradictionMayCost) {
  CameraModel camera;
  camera.pinhole = {700, 700, 600, 180};
  const auto widened = [&](const std::vector<ParameterEstimate>& contradictions) {
    RefinedScale refined;
    refined.estimate.emplace();
    refined.estimate->length_sigma = 0.03;
    refined.keyframes = {{.sigma = 0.02}, {.sigma = 0.05}};
    WidenForCalibration(contradictions, {Off(IntrinsicsParameter::kCentreX, 9)}, camera, refined);
    EXPECT_EQ(refined.doubtful_calibration.empty(), !contradictions.empty());
    EXPECT_EQ(refined.doubt_sigma == 0, !contradictions.empty());
    if (contradictions.empty()) return refined.calibration_sigma;
    EXPECT_EQ(refined.contradicted_calibration.size(), contradictions.size());
    EXPECT_EQ(refined.calibration_sigma, CalibrationSigma(contradictions, camera));
    const auto gained = [](double after, double before) { return after * after - before * before; };
    EXPECT_NEAR(gained(refined.keyframes[0].sigma, 0.02), gained(refined.estimate->length_sigma, 0.03), 1e-12);
    EXPECT_NEAR(gained(refined.keyframes[1].sigma, 0.05), gained(refined.estimate->length_sigma, 0.03), 1e-12);
    return gained(refined.estimate->length_sigma, 0.03);
  };
  EXPECT_NEAR(widened({}), 3 * 9.0 / 700, 1e-9) << "by the doubt";
  const double focal = widened({Off(IntrinsicsParameter::kFocalLength, 20)});
  const double centre = widened({Off(IntrinsicsParameter::kCentreX, -15)});
  EXPECT_GT(focal, 0.0025) << "3 % of the focal length cost more than 5 % of scale";
  EXPECT_GT(centre, 0);
  EXPECT_NEAR(widened({Off(IntrinsicsParameter::kFocalLength, -40)}), 4 * focal, 1e-9);
  EXPECT_NEAR(widened({Off(IntrinsicsParameter::kFocalLength, 20), Off(IntrinsicsParameter::kCentreX, -15)}),
              focal + centre, 1e-9);
  const double vertical = widened({Off(IntrinsicsParameter::kCentreY, -15)});
  EXPECT_EQ(vertical, centre);
  camera.pinhole.fy = 350;
  EXPECT_NEAR(widened({Off(IntrinsicsParameter::kCentreY, -15)}), 4 * vertical, 1e-9) << "twice the angle";
  EXPECT_EQ(widened({Off(IntrinsicsParameter::kCentreX, -15)}), centre);
  EXPECT_NEAR(widened({Off(IntrinsicsParameter::kPixelAspect, 50)}), 0.01, 1e-9) << "relative to what was given";
  RefinedScale pending;
  pending.keyframes = {{.sigma = 1}};
  WidenForCalibration({Off(IntrinsicsParameter::kDistortion, 0.01)}, {}, camera, pending);
  EXPECT_EQ(pending.keyframes[0].sigma, 1);
  EXPECT_EQ(pending.contradicted_calibration.size(), 1u);
}

TEST(WidenForHeight, AddsWhatTheScaleIsProbablyOff) {
  RefinedScale refined;
  refined.estimate.emplace();
  refined.estimate->length_sigma = 0.03;
  refined.estimate->car.camera_height = 0.28;
  refined.estimate->car.camera_height_sigma = 0.02;
  refined.keyframes = {{.sigma = 0.02}};
  RefinedScale single = refined;
  single.estimate->uses_single_turns = true;
  single.estimate->single_turn_offset = std::log(5);
  RefinedScale vague = refined;
  WidenScale(1.5, vague);
  for (RefinedScale* other : {&single, &vague}) {
    WidenForHeight(*other);
    EXPECT_FALSE(other->unusual_height);
    EXPECT_FALSE(other->estimate->is_doubtful);
  }
  EXPECT_NEAR(HeightByScale(*single.estimate), 1.4, 1e-12) << "a usual height by the scale that is used";
  WidenForHeight(refined);
  ASSERT_TRUE(refined.unusual_height);
  EXPECT_NEAR(refined.estimate->length_sigma, std::hypot(0.03, std::log(5)), 1e-12);
  EXPECT_NEAR(refined.keyframes[0].sigma, std::hypot(0.02, std::log(5)), 1e-12);
  EXPECT_EQ(refined.calibration_sigma, 0);
  EXPECT_TRUE(refined.estimate->is_doubtful);
}

}  // namespace
}  // namespace turnscale
