// SPDX-License-Identifier: MIT
#include "turnscale/odometry/camera_refinement.h"

#include <optional>

#include <gtest/gtest.h>
#include <opencv2/core/utility.hpp>

#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

constexpr double kDistortion = -0.012;
constexpr int kCorner = 36;  // keyframes, the latest of which are in the corner

class CameraRefining : public testing::TestWithParam<int> {
 protected:
  CameraRefining() {
    cv::setNumThreads(GetParam());
    const CarDrive drive =
        MakeCarDrive({{20, 0.8, 0}, {20, 0.7, 0.07}, {25, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
    whole_ = MakeMap(drive, {.points_per_step = 25, .pixel_noise = 0.3, .seed = 3});
    // Its pixels are as the lens shows them.
    whole_.camera.radial_correction = kDistortion;
    CorrectLens(whole_, 0);
  }
  ~CameraRefining() override { cv::setNumThreads(before_); }

  Map MapOf(int keyframes) const { return MapUpTo(keyframes, whole_); }

  OdometryOptions options_;
  Map whole_;

 private:
  int before_ = cv::getNumThreads();
};

TEST_P(CameraRefining, FindingsAreTakenSomeKeyframesAfterTheWindow) {
  CameraRefinement refinement(options_, whole_.camera);
  refinement.StartIfDue(MapOf(kCorner));
  EXPECT_FALSE(refinement.TakeIfDue(MapOf(kCorner + 3)));
  const std::optional<double> correction = refinement.TakeIfDue(MapOf(kCorner + 4));
  LensRefinement at_once(options_.lens);
  std::optional<IntrinsicsProblem> window = at_once.TakeWindow(MapOf(kCorner));
  ASSERT_TRUE(window && at_once.Read(*window));
  EXPECT_EQ(correction, at_once.correction());
  EXPECT_FALSE(refinement.TakeIfDue(MapOf(kCorner + 5))) << "once";
}

TEST_P(CameraRefining, WhatIsReadIsKnownBeforeItIsTaken) {
  CameraRefinement refinement(options_, whole_.camera);
  refinement.StartIfDue(MapOf(kCorner));
  EXPECT_NEAR(refinement.lens().correction(), kDistortion, 0.004);
  EXPECT_EQ(refinement.calibration_check().windows(), 1);
  EXPECT_TRUE(refinement.TakeIfDue(MapOf(kCorner + 4))) << "it has not been taken by that";
  EXPECT_NEAR(refinement.lens().correction(), kDistortion, 0.004);
}

TEST_P(CameraRefining, FindingsMayBeWantedAtOnce) {
  CameraRefinement refinement(options_, whole_.camera);
  refinement.StartIfDue(MapOf(kCorner));
  refinement.Hurry();
  EXPECT_TRUE(refinement.TakeIfDue(MapOf(kCorner)));
}

TEST_P(CameraRefining, AMapWithTheCorrectionKeepsIt) {
  CameraRefinement refinement(options_, whole_.camera);
  refinement.StartIfDue(MapOf(kCorner));
  Map map = MapOf(kCorner + 4);
  CorrectLens(map, refinement.lens().correction());
  EXPECT_FALSE(refinement.TakeIfDue(map));
}

TEST_P(CameraRefining, AnUncertainCalibrationWidensTheScale) {
  CameraModel camera = whole_.camera;
  EXPECT_EQ(CameraRefinement(options_, camera).scale_sigma(), 0);
  camera.focal_sigma = 0.02 * camera.pinhole.fx;
  EXPECT_GT(CameraRefinement(options_, camera).scale_sigma(), 0);
}

INSTANTIATE_TEST_SUITE_P(OneAndTwoThreads, CameraRefining, testing::Values(1, 2));

}  // namespace
}  // namespace turnscale
