// SPDX-License-Identifier: MIT
#include "turnscale/odometry/gap_rotation.h"

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/features/synthetic_texture.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/test_boards.h"

namespace turnscale {
namespace {

Mount MountedAt(const Eigen::Quaterniond& vehicle_from_camera) {
  constexpr double kSigma = 0.3 / kDegreesPerRadian;
  return {.vehicle_from_camera = vehicle_from_camera, .found = true, .sigma = {kSigma, kSigma, kSigma}};
}

const Eigen::Quaterniond kLevel = Eigen::Quaterniond::Identity();

// At `x` to the right and `z` ahead of the start, after a turn to the right, radians.
RigidTransform At(double x, double z, double turn) {
  return RigidTransform{RotationFromVector({0, turn, 0}), {x, 0, z}}.inverse();
}

cv::Mat Seen(const RigidTransform& camera_from_world) { return Boards(3).Seen(SmallCamera(), camera_from_world); }

std::optional<Eigen::Quaterniond> Measured(const GapImages& images, const Mount& mount = MountedAt(kLevel)) {
  const std::optional<GapRotation> rotation = MeasureGapRotation({}, SmallCamera(), images, {}, mount);
  return rotation ? std::optional(rotation->after_from_before) : std::nullopt;
}

double DegreesBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return InDegrees(RotationAngle(a.conjugate() * b));
}

TEST(GapRotation, IsMeasuredWhereBothImagesShowTheSame) {
  for (const double turn : {-0.25, 0.0, 0.25}) {
    const RigidTransform after = At(0.6 * turn, 1.2, turn);
    const auto rotation = Measured({Seen(At(0, 0, 0)), {}, Seen(after)});
    ASSERT_TRUE(rotation) << turn;
    EXPECT_LT(DegreesBetween(*rotation, after.rotation), 0.5) << turn;
  }
}

TEST(GapRotation, NothingInCommonTellsNothing) {
  const cv::Mat elsewhere = Boards(50).Seen(SmallCamera(), At(0, 0, 0));
  EXPECT_FALSE(Measured({Seen(At(0, 0, 0)), {}, elsewhere}));
  EXPECT_FALSE(Measured({Seen(At(0, 0, 0)), elsewhere, elsewhere}));
  EXPECT_FALSE(Measured({Seen(At(0, 0, 0)), {}, cv::Mat::zeros(240, 480, CV_8UC1)}));
}

TEST(GapRotation, IsMeasuredByWayOfTheFirstImageAfterTheGap) {
  const RigidTransform after = At(0.1, 1.6, 0.1);
  GapImages images = {Seen(At(0, 0, 0)), Seen(At(0.05, 0.8, 0.05)), Seen(after)};
  // The left half of the scene is in the image before the gap, the right half in the one after it.
  images.before.colRange(240, 480).setTo(0);
  images.after.colRange(0, 240).setTo(0);
  ASSERT_FALSE(Measured({images.before, {}, images.after}));
  const auto rotation = Measured(images);
  ASSERT_TRUE(rotation);
  EXPECT_LT(DegreesBetween(*rotation, after.rotation), 1);
}

TEST(GapRotation, IsThatOfACar) {
  const GapImages sideways = {Seen(At(0, 0, 0)), {}, Seen(At(1, 0.2, 0))};
  EXPECT_FALSE(Measured(sideways)) << "no car moves sideways";
  EXPECT_TRUE(Measured(sideways, MountedAt(RotationFromVector({0, -1.37, 0})))) << "the camera looks to the left";
  EXPECT_TRUE(Measured({Seen(At(0, 1.2, 0)), {}, Seen(At(0, 0, 0))})) << "in reverse";
  RigidTransform tilted = At(0, 1.2, 0);
  tilted = RigidTransform{RotationFromVector({0, 0, 0.15}), {0, 0, 0}} * tilted;
  EXPECT_FALSE(Measured({Seen(At(0, 0, 0)), {}, Seen(tilted)})) << "no car leans like this";
}

TEST(GapRotation, OfACarThatStood) {
  const cv::Mat image = Seen(At(0, 0, 0));
  const auto same = Measured({.before = image, .lost = {}, .after = image, .car_stood = true});
  ASSERT_TRUE(same);
  EXPECT_LT(DegreesBetween(*same, kLevel), 0.1);
  EXPECT_FALSE(Measured({image, {}, image})) << "a car that drives does not see the same again";
  const auto turned = Measured({image, {}, Seen(At(0, 0, 0.2))});
  ASSERT_TRUE(turned);
  EXPECT_LT(DegreesBetween(*turned, At(0, 0, 0.2).rotation), 0.1);
}

// The lower part of the image is a dashboard, from this row on.
cv::Mat WithDashboard(cv::Mat image, int row) {
  const SyntheticTexture texture(77, 8, 60);
  const cv::Mat dashboard = MakeImage(image.size(), [&](const Eigen::Vector2d& pixel) { return texture.At(pixel); });
  dashboard.rowRange(row, image.rows).copyTo(image.rowRange(row, image.rows));
  return image;
}

TEST(GapRotation, ADashboardIsNoneOfTheScene) {
  constexpr int kLarge = 80;
  constexpr int kSmall = 150;
  for (const int row : {kSmall, kLarge}) {
    const cv::Mat before = WithDashboard(Seen(At(0, 0, 0)), row);
    const cv::Mat elsewhere = WithDashboard(Boards(50).Seen(SmallCamera(), At(0, 0, 0)), row);
    EXPECT_FALSE(Measured({before, {}, elsewhere})) << "the car has turned away, row " << row;
    EXPECT_FALSE(Measured({before, elsewhere, elsewhere})) << row;
    EXPECT_TRUE(Measured({.before = before, .lost = {}, .after = elsewhere, .car_stood = true})) << row;
  }
  const cv::Mat before = WithDashboard(Seen(At(0, 0, 0)), kSmall);
  const RigidTransform after = At(0.06, 1.2, 0.25);
  const auto turned = Measured({before, {}, WithDashboard(Seen(after), kSmall)});
  ASSERT_TRUE(turned);
  EXPECT_LT(DegreesBetween(*turned, after.rotation), 0.5);
}

TEST(GapRotation, FarPointsStandStillOnAStraight) {
  constexpr double kTurn = 0.07;
  constexpr int kRow = 150;
  const Eigen::Quaterniond turned = At(0, 0, kTurn).rotation.conjugate();
  const cv::Mat elsewhere = WithDashboard(Boards(50).Seen(SmallCamera(), At(0, 0, 0)), kRow);
  const cv::Mat before = WithDashboard(Seen(At(0, 0, 0)), kRow);
  const cv::Mat& after = before;
  const cv::Mat earlier = WithDashboard(Seen(At(0, 0, kTurn)), kRow);
  EXPECT_FALSE(Measured({.before = before, .after = after})) << "all that stands still may be the dashboard";
  const auto straight = Measured({.before = before, .after = after, .earlier = {earlier, turned}});
  ASSERT_TRUE(straight) << "the camera had turned towards what stands still now";
  EXPECT_LT(DegreesBetween(*straight, kLevel), 0.1);
  EXPECT_FALSE(Measured({.before = before, .after = elsewhere, .earlier = {earlier, turned}}))
      << "the dashboard stood still then, too";
  EXPECT_FALSE(Measured({.before = before, .after = after, .earlier = {earlier, kLevel}}))
      << "what moves otherwise than by the rotation is not far away";
}

TEST(GapRotation, FarPointsTellItWhereNearOnesMislead) {
  constexpr double kTurn = 0.07;
  constexpr int kRow = 110;
  // What is below the far scene seems to move sideways, as where each thing in a row is taken for the next.
  const auto seen = [](double turn, double sideways) {
    cv::Mat image = Boards(50).Seen(SmallCamera(), At(sideways, 0.2 * sideways, turn));
    Seen(At(0, 0, turn)).rowRange(0, kRow).copyTo(image.rowRange(0, kRow));
    return image;
  };
  const cv::Mat before = seen(0, 0);
  const cv::Mat after = seen(-0.05, 1);
  EXPECT_FALSE(Measured({.before = before, .after = after}));
  const Eigen::Quaterniond turned = At(0, 0, kTurn).rotation.conjugate();
  const auto rotation = Measured({.before = before, .after = after, .earlier = {seen(kTurn, 0.5), turned}});
  ASSERT_TRUE(rotation);
  EXPECT_LT(DegreesBetween(*rotation, At(0, 0, -0.05).rotation), 0.2);
}

TEST(GapRotation, ACameraThatMayBePitchedIsAllowedSomeTilt) {
  // Pitched by 8 degrees, which the mount does not know yet.
  const RigidTransform pitched{RotationFromVector({0.14, 0, 0}), Eigen::Vector3d::Zero()};
  const GapImages images = {Seen(pitched * At(0, 0, -0.35)), {}, Seen(pitched * At(0.1, 1.2, 0.35))};
  EXPECT_FALSE(Measured(images));
  Mount unknown = MountedAt(kLevel);
  unknown.found = false;
  EXPECT_TRUE(Measured(images, unknown));
}

TEST(GapRotationOptions, RefusesSenselessValues) {
  using Options = GapRotationOptions;
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.keypoints.max_keypoints = 0; }), "max_keypoints");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_epipolar_error = 0; }), "max_epipolar_error");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_still_motion = 2; }), "max_still_motion");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_matches = 4; }), "min_matches");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_match_share = 1.1; }), "min_match_share");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_still_share = -1; }), "min_still_share");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_plane_share = 2; }), "max_plane_share");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_tilt_deg = 0; }), "max_tilt_deg");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_direction_error_deg = 0; }), "max_direction_error_deg");
}

}  // namespace
}  // namespace turnscale
