// SPDX-License-Identifier: MIT
#include "turnscale/odometry/options.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

template <typename Change>
std::string Refused(Change change) {
  return RefusedField<OdometryOptions>(change);
}

TEST(OdometryOptions, DefaultsAreGood) {
  EXPECT_EQ(Refused([](auto&) {}), "");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.lever_arm = 1.2; }), "");
}

TEST(OdometryOptions, WithoutMetresNothingOfTheCarGivesTheScale) {
  OdometryOptions options;
  options.vehicle.lever_arm = 1.2;
  options.vehicle.camera_height = 1.5;
  options.vehicle.camera_height_sigma = 0.02;
  const OdometryOptions free = WithoutMetres(options);
  EXPECT_FALSE(free.vehicle.lever_arm);
  EXPECT_FALSE(free.vehicle.camera_height);
  EXPECT_NO_THROW(free.Check());
}

TEST(OdometryOptions, AreThoseGivenWhateverTheCamera) {
  OdometryOptions options;
  options.vehicle.camera_height = 1.5;
  options.vehicle.height_correlation = 0.8;
  CameraModel camera{.pinhole = {300, 300, 160, 120}};
  camera.aspect_sigma = 0.03;
  const Odometry odometry(options, camera);
  EXPECT_FALSE(odometry.options().vehicle.camera_height_sigma) << "a run with these settings is the same again";
  EXPECT_EQ(odometry.options().vehicle.height_correlation, 0.8);
}

TEST(OdometryOptions, NameTheFieldThatMakesNoSense) {
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.lever_arm = 0; }), "vehicle.lever_arm");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.lever_arm = std::nan(""); }), "vehicle.lever_arm");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.lever_arm = HUGE_VAL; }), "vehicle.lever_arm");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.lever_arm = 145; }), "vehicle.lever_arm") << "centimetres";
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.camera_height = 150; }), "vehicle.camera_height");
  const auto correlate = [](double arm_height, double slip_height, double arm_slip) {
    return Refused([&](auto& o) {
      o.vehicle.height_correlation = arm_height;
      o.vehicle.height_slip_correlation = slip_height;
      o.vehicle.lever_arm_slip_correlation = arm_slip;
    });
  };
  EXPECT_EQ(correlate(0.9, 0.9, 0.9), "");
  EXPECT_EQ(correlate(0.9, 0.9, 0), "vehicle.height_slip_correlation");
  EXPECT_EQ(correlate(0.9, -0.9, 0.9), "vehicle.lever_arm_slip_correlation");
  EXPECT_EQ(correlate(0, 0, 1), "vehicle.lever_arm_slip_correlation");
  EXPECT_EQ(Refused([](auto& o) { o.turn_bundle.window = 1; }), "turn_bundle.window");
  EXPECT_EQ(Refused([](auto& o) { o.final_bundle.anchors = 0; }), "final_bundle.anchors");
  EXPECT_EQ(Refused([](auto& o) { o.scale.recovery.max_iterations = 0; }), "scale.recovery.max_iterations");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.side_slip = -0.1; }), "vehicle.side_slip");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.vehicle_from_camera.coeffs() *= 2; }), "vehicle.vehicle_from_camera");
  EXPECT_EQ(Refused([](auto& o) { o.keyframes.min_rotation_deg = 0; }), "keyframes.min_rotation_deg");
  EXPECT_EQ(Refused([](auto& o) { o.keyframes.min_parallax_deg = std::nan(""); }), "keyframes.min_parallax_deg");
  EXPECT_EQ(Refused([](auto& o) { o.keyframes.min_tracked_share = 1.01; }), "keyframes.min_tracked_share");
  EXPECT_EQ(Refused([](auto& o) { o.keyframes.min_followed_share = 1.01; }), "keyframes.min_followed_share");
  EXPECT_EQ(Refused([](auto& o) { o.keyframes.max_growth = 1; }), "keyframes.max_growth");
  EXPECT_EQ(Refused([](auto& o) { o.tracking.min_inliers = 5; }), "tracking.min_inliers");
  EXPECT_EQ(Refused([](auto& o) { o.tracking.min_inlier_share = -0.1; }), "tracking.min_inlier_share");
  EXPECT_EQ(Refused([](auto& o) { o.tracking.memory_keyframes = 0; }), "tracking.memory_keyframes");
  EXPECT_EQ(Refused([](auto& o) { o.tracking.max_lost_seconds = -1; }), "tracking.max_lost_seconds");
  EXPECT_EQ(Refused([](auto& o) { o.tracking.max_hidden_seconds = -1; }), "tracking.max_hidden_seconds");
  EXPECT_EQ(Refused([](auto& o) { o.tracking.sampled_interval = -1; }), "tracking.sampled_interval");
  EXPECT_EQ(Refused([](auto& o) { o.keyframes.min_motion = -1; }), "keyframes.min_motion");
  EXPECT_EQ(Refused([](auto& o) { o.tracking.min_lost_frames = 0; }), "tracking.min_lost_frames");
  EXPECT_EQ(Refused([](auto& o) { o.tracking.depth_sigma = 0; }), "tracking.depth_sigma");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.lever_arm_sigma = -1; }), "vehicle.lever_arm_sigma");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.lever_arm = o.vehicle.lever_arm_sigma = 0.5; }), "vehicle.lever_arm_sigma");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.lever_arm = 0.02; }), "") << "the default adapts";
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.side_slip_sigma = 1; }), "vehicle.side_slip_sigma");
  EXPECT_EQ(Refused([](auto& o) { o.vehicle.yaw_sigma = 0; }), "vehicle.yaw_sigma_deg");
  EXPECT_EQ(Refused([](auto& o) { o.scale.estimator.max_sigma_ratio = 0; }), "scale.max_sigma_ratio");
}

TEST(OdometryOptions, CheckEveryPart) {
  EXPECT_NE(Refused([](auto& o) { o.corners.target = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.flow.window = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.alignment.half_size = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.initialization.min_parallax = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.pose.inlier_threshold = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.landmarks.min_parallax_deg = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.local_bundle.window = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.lens.step = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.motion.turn_seconds = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.repeats.max_motion_share = 1; }), "");
  EXPECT_NE(Refused([](auto& o) { o.steps.max_poses = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.scale.estimator.segments.turns.min_steps = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.scale.estimator.evidence.line.sigma_theta = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.scale.estimator.drift.per_100m = -1; }), "");
  EXPECT_NE(Refused([](auto& o) { o.scale.estimator.huber = 0; }), "");
  EXPECT_NE(Refused([](auto& o) { o.scale.recovery.pixel_sigma = 0; }), "");
}

}  // namespace
}  // namespace turnscale
