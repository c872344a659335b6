// SPDX-License-Identifier: MIT
#include "turnscale/mapping/essential_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr Pinhole kPinhole{500, 500, 320, 240};
constexpr double kMaxError = 1;  // pixels

struct Matches {
  std::vector<Eigen::Vector2d> first;
  std::vector<Eigen::Vector2d> second;
};

// 200 points of a scene, each from two random numbers between -1 and 1, seen by a camera before and after it has
// travelled by `travel`; noise of a fifth of a pixel.
template <typename Scene>
Matches Seen(const Eigen::Vector3d& travel, Scene scene) {
  Random random(5);
  const RigidTransform second_from_first{Eigen::Quaterniond::Identity(), -travel};
  Matches matches;
  while (matches.first.size() < 200) {
    const double a = random.Uniform(-1, 1);
    const double b = random.Uniform(-1, 1);
    const Eigen::Vector3d x = scene(a, b);
    const Eigen::Vector3d y = second_from_first * x;
    if (x.z() < 0.5 || y.z() < 0.5) continue;
    const auto noise = [&] { return Eigen::Vector2d(0.2 * random.Gaussian(), 0.2 * random.Gaussian()); };
    matches.first.emplace_back(kPinhole.Project(x) + noise());
    matches.second.emplace_back(kPinhole.Project(y) + noise());
  }
  return matches;
}

EssentialMotion MotionOf(const Matches& matches) {
  return FindEssentialMotion(kPinhole, matches.first, matches.second, kMaxError);
}

bool MayBePassing(const Matches& matches, double yaw = 0) {
  return MayBePassingVehicle(kPinhole, MotionOf(matches), matches.first, matches.second, kMaxError,
                             RotationFromYawPitchRoll({yaw, 0, 0}));
}

const auto kDeepScene = [](double a, double b) {
  return Eigen::Vector3d(8 * a, 3 * b, 12 + 7 * std::sin(9 * a + 5 * b));
};
const auto kRoad = [](double a, double b) { return Eigen::Vector3d(4 * a, 1.4, 9 + 5 * b); };
const auto kSideOfALorry = [](double a, double b) { return Eigen::Vector3d(3 * a, 2 * b, 4 + 0.5 * a); };

TEST(EssentialMotion, IsFoundWithTheMatchesThatAgree) {
  Matches matches = Seen({0.1, 0, 1}, kDeepScene);
  for (size_t i = 0; i < 20; ++i) matches.second[i] += Eigen::Vector2d(-30, 40);
  const EssentialMotion motion = MotionOf(matches);
  const Eigen::Vector3d travel = motion.second_from_first.inverse().translation;
  EXPECT_LT((travel - Eigen::Vector3d(0.1, 0, 1).normalized()).norm(), 0.02);
  EXPECT_LT(RotationAngle(motion.second_from_first.rotation), 0.002);
  const auto agreeing = std::ranges::count(motion.agrees, 1);
  EXPECT_GT(agreeing, 160);
  EXPECT_LT(agreeing, 190);
  const std::optional<TwoViewGeometry> adjusted = AdjustTwoViews(kPinhole, motion, matches.first, matches.second);
  ASSERT_TRUE(adjusted);
  EXPECT_GT(adjusted->points.size(), 150U);
  for (size_t k = 0; k < adjusted->points.size(); ++k) {
    const Eigen::Vector2d& pixel = matches.first[adjusted->match_of_point[k]];
    EXPECT_LT((kPinhole.Project(adjusted->points[k]) - pixel).norm(), 2 * kMaxError) << k;
  }
}

TEST(EssentialMotion, SharesOnAPlane) {
  const auto share = [](const Matches& matches) {
    return ShareOnPlane(MotionOf(matches), matches.first, matches.second, kMaxError);
  };
  EXPECT_GT(share(Seen({1, 0, 0}, kSideOfALorry)), 0.9);
  EXPECT_LT(share(Seen({0, 0, 1}, kDeepScene)), 0.6);
}

TEST(EssentialMotion, WhatPassesSidewaysMayBeAVehicle) {
  EXPECT_TRUE(MayBePassing(Seen({1, 0, 0}, kSideOfALorry)));
  EXPECT_TRUE(MayBePassing(Seen({-1, 0.05, 0.1}, kSideOfALorry)));
}

TEST(EssentialMotion, ARoadOrAWallAheadIsNoPassingVehicle) {
  EXPECT_FALSE(MayBePassing(Seen({0, 0, 1}, kRoad)));
  EXPECT_FALSE(MayBePassing(Seen({0.1, 0, 1}, kRoad)));
  EXPECT_FALSE(MayBePassing(Seen({0, 0, 1}, kSideOfALorry))) << "straight ahead";
  EXPECT_FALSE(MayBePassing(Seen({0, 0, 1}, kDeepScene)));
  EXPECT_FALSE(MayBePassing(Seen({1, 0, 0}, kDeepScene))) << "no plane";
  EXPECT_FALSE(MayBePassing(Seen({-1, 0, 1}, kRoad), 0.8))
      << "straight ahead, seen by a camera that looks to the right";
  EXPECT_FALSE(MayBePassingVehicle(kPinhole, {}, {}, {}, kMaxError, Eigen::Quaterniond::Identity())) << "no matches";
}

}  // namespace
}  // namespace turnscale
