// SPDX-License-Identifier: MIT
#include "turnscale/mapping/map_scaling.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

std::vector<Eigen::Vector3d> Line(const std::vector<double>& z) {
  std::vector<Eigen::Vector3d> centres;
  centres.reserve(z.size());
  for (const double value : z) centres.emplace_back(0, 0, value);
  return centres;
}

TEST(MapScaling, FactorsPassFromTurnToTurnOverThePath) {
  // Steps 1..7; the middle one of the three between the turns is as long as the other two together.
  const auto centres = Line({0, 1, 2, 3, 5, 6, 7, 8});
  const auto factors = StepFactors(centres, {{2, 2, 2.0, {}}, {6, 6, 8.0, {}}});
  ASSERT_EQ(factors.size(), 8u);
  EXPECT_EQ(factors[1], 2.0);
  EXPECT_EQ(factors[2], 2.0);
  EXPECT_NEAR(factors[3], 2.0 * std::pow(4.0, 0.125), 1e-15);
  EXPECT_NEAR(factors[4], 4.0, 1e-15);
  EXPECT_NEAR(factors[5], 2.0 * std::pow(4.0, 0.875), 1e-14);
  EXPECT_EQ(factors[6], 8.0);
  EXPECT_EQ(factors[7], 8.0);
}

TEST(MapScaling, StandstillBetweenTurnsIsNoDivisionByZero) {
  const auto factors = StepFactors(Line({0, 1, 1, 2}), {{1, 1, 1.0, {}}, {3, 3, 4.0, {}}});
  EXPECT_NEAR(factors[2], 2.0, 1e-15);
}

TEST(MapScaling, ScalesEachStepAndTheWorld) {
  const auto centres = Line({1, 2, 4, 5});
  const auto scaled = ScaleSteps(centres, {0, 10, 2, 3});
  EXPECT_EQ(scaled[0].z(), 10);
  EXPECT_EQ(scaled[1].z(), 20);
  EXPECT_EQ(scaled[2].z(), 24);
  EXPECT_EQ(scaled[3].z(), 27);
  const auto world = ScaleSteps(centres, {10, 10, 10, 10});
  for (std::size_t k = 0; k < centres.size(); ++k) EXPECT_EQ(world[k], 10 * centres[k]);
}

TEST(MapScaling, KeyframeFactorsFollowThePath) {
  const auto before = Line({0, 1, 2, 3, 4, 5, 6, 7, 7, 7, 7, 7, 7});
  const auto after = Line({0, 1, 2, 3, 6, 9, 12, 15, 15, 15, 15, 15, 15});
  const auto factors = KeyframeFactors(before, after, 1, std::vector<double>(13, 7.0));
  EXPECT_EQ(factors[0], 1.0);
  EXPECT_EQ(factors[1], 1.0);
  EXPECT_EQ(factors[3], 2.0) << "half of the steps around it have grown";
  EXPECT_EQ(factors[5], 3.0);
  EXPECT_EQ(factors[11], 7.0) << "where nothing moves the fallback stands";
}

TEST(MapScaling, LandmarksGoWithTheKeyframeThatSawThemFromClosestBy) {
  Map map;
  map.landmarks.push_back({{0, 1, 5}, true, {{1, {0, 0}}, {2, {0, 0}}, {0, {0, 0}}}});
  map.landmarks.push_back({{0, 1, 0}, true, {{0, {0, 0}}, {2, {0, 0}}}});
  map.landmarks.push_back({{0, 1, 5}, true, {{2, {0, 0}}}});
  CarryLandmarks(Line({0, 1, 2}), Line({0, 10, 20}), 1, {1, 2, 3}, {0, 1}, map);
  EXPECT_EQ(map.landmarks[0].position, Eigen::Vector3d(0, 3, 29));
  EXPECT_EQ(map.landmarks[1].position, Eigen::Vector3d(0, 1, 0)) << "by a keyframe before the first that moves";
  EXPECT_EQ(map.landmarks[2].position, Eigen::Vector3d(0, 1, 5)) << "not on the list";
}

TEST(MapScaling, CentresComeBackAndRotationsStay) {
  Map map;
  map.keyframes.resize(2);
  map.keyframes[1].camera_from_world = {RotationFromVector({0.1, 0.5, -0.2}), {1, 2, 3}};
  auto centres = KeyframeCentres(map);
  EXPECT_LT((map.keyframes[1].camera_from_world * centres[1]).norm(), 1e-15);
  centres[1] *= 2;
  const Eigen::Quaterniond rotation = map.keyframes[1].camera_from_world.rotation;
  SetKeyframeCentres(centres, map);
  EXPECT_EQ(map.keyframes[1].camera_from_world.rotation.coeffs(), rotation.coeffs());
  EXPECT_LT((map.keyframes[1].camera_from_world.translation - Eigen::Vector3d(2, 4, 6)).norm(), 1e-14);
}

}  // namespace
}  // namespace turnscale
