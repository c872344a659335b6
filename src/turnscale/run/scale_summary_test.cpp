// SPDX-License-Identifier: MIT
#include "turnscale/run/scale_summary.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/run/run_summary.h"
#include "turnscale/run/test_path.h"

namespace turnscale {
namespace {

TEST(ScaleSummary, AContradictedCalibrationMayBeWhyTheScaleIsPending) {
  RefinedScale scale;
  scale.reason = "no turn";
  scale.contradicted_calibration.emplace_back();
  DriveFacts drive;
  const auto reason = [&] { return ScaleSummaryOf(drive, {}, scale, {}).pending_reason; };
  EXPECT_EQ(reason(), "no turn");
  drive.vehicle.lever_arm = 1.5;
  EXPECT_TRUE(reason().starts_with("no turn; the images contradict the calibration"));
  drive.images.blending.emplace();
  EXPECT_TRUE(reason().starts_with("no turn; the images are blended, which may be the cause"));
}

TEST(ScaleSummary, ImpossibleMotionIsNamedAndPartOfSigma) {
  std::vector<FrameResult> refined(600);
  double place = 0;
  for (size_t i = 0; i < refined.size(); ++i) {
    place += i > 200 && i <= 300 ? 0.2 : 2;
    refined[i].time = 0.1 * static_cast<double>(i);
    refined[i].state = TrackingState::kTracked;
    refined[i].scale_state = ScaleState::kHeld;
    refined[i].world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, place}};
  }
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  scale.estimate->length_sigma = 0.02;
  const RunSummary summary = SummaryOf({}, refined, scale);
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_NE(summary.warnings[0].find("faster than a car's can"), std::string::npos) << summary.warnings[0];
  EXPECT_NEAR(summary.scale.path_sigma, 0.18, 0.02) << "about 180 m of 1020 m";
}

TEST(ScaleSummary, ImpossibleDirectionsAreNamedAndPartOfSigma) {
  std::vector<FrameResult> refined(600);
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < refined.size(); ++i) {
    place += i > 200 && i <= 260 ? Eigen::Vector3d(1, 0, 0) : Eigen::Vector3d(0, 0, 1);
    refined[i].time = 0.1 * static_cast<double>(i);
    refined[i].state = TrackingState::kTracked;
    refined[i].scale_state = ScaleState::kHeld;
    refined[i].world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), place};
  }
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  scale.estimate->length_sigma = 0.02;
  const RunSummary summary = SummaryOf({}, refined, scale);
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_NE(summary.warnings[0].find("90 degrees to the right"), std::string::npos) << summary.warnings[0];
  EXPECT_NEAR(summary.scale.path_sigma, 0.1, 0.02) << "60 m of 599 m";
}

// 10 frames and 10 m a second, without a map for `late` frames; a short beginning counts, but is not worth a line.
TEST(ScaleSummary, ABeginningWithoutAMapWidensSigma) {
  const auto summary_of = [](int late, TrackingState last_of_them, int count = 100) {
    std::vector<FrameResult> frames(count);
    for (int i = 0; i < count; ++i) {
      frames[i].time = 0.1 * i;
      frames[i].state = i >= late       ? TrackingState::kTracked
                        : i + 1 == late ? last_of_them
                                        : TrackingState::kInitializing;
      frames[i].world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, double(std::max(i, late))}};
      frames[i].keyframe = true;
    }
    RefinedScale scale = HeldScale();
    scale.estimate.emplace().converged = true;
    scale.estimate->length_sigma = 0.05;
    return SummaryOf({}, frames, scale);
  };
  EXPECT_NEAR(summary_of(0, TrackingState::kTracked).scale.path_sigma, 0.05, 1e-9);
  for (const TrackingState last : {TrackingState::kInitializing, TrackingState::kUnreadable}) {
    const RunSummary brief = summary_of(4, last);
    EXPECT_NEAR(brief.scale.path_sigma, std::hypot(0.05, 4 / 95.0), 1e-6);
    EXPECT_TRUE(brief.warnings.empty());
    EXPECT_TRUE(summary_of(10, last, 1000).warnings.empty()) << "1 % of the drive";
    EXPECT_EQ(summary_of(20, last, 1000).warnings.size(), 1u) << "two seconds";
    const RunSummary late = summary_of(10, last);
    EXPECT_NEAR(late.scale.path_sigma, std::hypot(0.05, 10 / 89.0), 1e-6);
    ASSERT_EQ(late.warnings.size(), 1u);
    EXPECT_NE(late.warnings[0].find(
                  "before 1.0 s (10 of 100 frames); if the car drove there, the path lacks up to about 10 m"),
              std::string::npos)
        << late.warnings[0];
  }
}

TEST(CarSummary, TheHeightIsAsUncertainAsTheScale) {
  RefinedScale scale;
  scale.estimate.emplace();
  scale.estimate->car.camera_height = 1.5;
  scale.estimate->car.camera_height_sigma = 0.03;
  DriveFacts drive;
  const auto sigma = [&] { return CarSummaryOf(drive, scale).refined->camera_height_sigma; };
  EXPECT_EQ(sigma(), 0.03);
  scale.calibration_sigma = 0.2;
  EXPECT_NEAR(sigma(), std::hypot(0.03, 0.3), 1e-12) << "a wrong calibration";
  scale.calibration_sigma = 0;
  scale.aspect_sigma = 0.02;
  EXPECT_NEAR(sigma(), std::hypot(0.03, 0.03), 1e-12) << "of the pixels' aspect";
  drive.vehicle.camera_height = 1.5;
  EXPECT_EQ(sigma(), 0.03) << "which the prior of a measured height has";
  drive.vehicle.height_from_images = true;
  EXPECT_NEAR(sigma(), std::hypot(0.03, 0.03), 1e-12) << "unlike that of one that an earlier drive has found";
  scale.aspect_sigma = 0;
  scale.estimate->height_conflict = HeightConflict{1.4, 0.014, 1.26, 0.02, false};
  EXPECT_NEAR(sigma(), std::hypot(0.03, 1.5 * 0.5 * std::log(1.4 / 1.26)), 1e-12) << "between two lengths";
  scale.estimate->height_conflict.reset();
  scale.estimate->slip_conflict.emplace();
  scale.estimate->test.disagreement = 0.1;
  EXPECT_NEAR(sigma(), std::hypot(0.03, 0.15), 1e-12) << "an unusual slip";
}

TEST(CarSummary, HasWhatTheDriveTellsOfTheCar) {
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  scale.estimate->car_evidence.prior.covariance.setIdentity();
  scale.estimate->car_evidence.posterior.mean[1] = 0.005;
  scale.estimate->car_evidence.posterior.covariance(1, 3) = -0.25;
  RunSummary summary;
  summary.car = CarSummaryOf({}, scale);
  const auto told = nlohmann::json::parse(SummaryJson(summary))["car_evidence"];
  EXPECT_EQ(told["unknowns"][1], "side_slip_s2_per_m");
  EXPECT_EQ(told["posterior"]["mean"][1], 0.005);
  EXPECT_EQ(told["posterior"]["covariance"][1][3], -0.25);
  EXPECT_EQ(told["prior"]["covariance"][2][2], 1);
  EXPECT_EQ(told["inflation"], 1);
  scale.estimate->uses_single_turns = true;
  EXPECT_FALSE(CarSummaryOf({}, scale).evidence);
}

}  // namespace
}  // namespace turnscale
