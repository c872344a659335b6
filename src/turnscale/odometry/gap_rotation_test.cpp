// SPDX-License-Identifier: MIT
#include "turnscale/odometry/gap_rotation.h"

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/test_boards.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kLevel = Eigen::Quaterniond::Identity();

// At `x` to the right and `z` ahead of the start, after a turn to the right, radians.
RigidTransform At(double x, double z, double turn) {
  return RigidTransform{RotationFromVector({0, turn, 0}), {x, 0, z}}.inverse();
}

cv::Mat Seen(const RigidTransform& camera_from_world) { return Boards(3).Seen(SmallCamera(), camera_from_world); }

std::optional<Eigen::Quaterniond> Measured(const GapImages& images,
                                           const Eigen::Quaterniond& vehicle_from_camera = kLevel) {
  return RotationAcrossGap({}, SmallCamera(), images, {}, vehicle_from_camera);
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
  const RigidTransform lost = At(0.3, 1, 0.65);
  const RigidTransform after = At(0.9, 1.6, 1.3);
  const GapImages images = {Seen(At(0, 0, 0)), Seen(lost), Seen(after)};
  ASSERT_FALSE(Measured({images.before, {}, images.after})) << "too little in common";
  const auto rotation = Measured(images);
  ASSERT_TRUE(rotation);
  EXPECT_LT(DegreesBetween(*rotation, after.rotation), 1);
}

TEST(GapRotation, IsThatOfACar) {
  const GapImages sideways = {Seen(At(0, 0, 0)), {}, Seen(At(1, 0.2, 0))};
  EXPECT_FALSE(Measured(sideways)) << "no car moves sideways";
  EXPECT_TRUE(Measured(sideways, RotationFromVector({0, -1.37, 0}))) << "the camera looks to the left";
  EXPECT_TRUE(Measured({Seen(At(0, 1.2, 0)), {}, Seen(At(0, 0, 0))})) << "in reverse";
  RigidTransform tilted = At(0, 1.2, 0);
  tilted = RigidTransform{RotationFromVector({0, 0, 0.15}), {0, 0, 0}} * tilted;
  EXPECT_FALSE(Measured({Seen(At(0, 0, 0)), {}, Seen(tilted)})) << "no car leans like this";
}

TEST(GapRotationOptions, RefusesSenselessValues) {
  using Options = GapRotationOptions;
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.keypoints.max_keypoints = 0; }), "max_keypoints");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_epipolar_error = 0; }), "max_epipolar_error");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_matches = 4; }), "min_matches");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.min_match_share = 1.1; }), "min_match_share");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_tilt_deg = 0; }), "max_tilt_deg");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_direction_error_deg = 0; }), "max_direction_error_deg");
}

}  // namespace
}  // namespace turnscale
