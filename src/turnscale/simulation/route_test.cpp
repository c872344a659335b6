// SPDX-License-Identifier: MIT
#include "turnscale/simulation/route.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// Turning angle per distance at each inner point.
std::vector<double> Curvatures(const Points& points) {
  std::vector<double> curvatures;
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Eigen::Vector2d a = points[i] - points[i - 1];
    const Eigen::Vector2d b = points[i + 1] - points[i];
    const double angle = std::atan2(a.y() * b.x() - a.x() * b.y(), a.dot(b));
    curvatures.push_back(2 * angle / (a.norm() + b.norm()));
  }
  return curvatures;
}

TEST(RoundCorners, KeepsEndsStepAndRadius) {
  const Points path = RoundCorners({{0, 0}, {0, 30}, {30, 30}, {30, 60}}, 6, 0.5);
  EXPECT_EQ(path.front(), Eigen::Vector2d(0, 0));
  EXPECT_EQ(path.back(), Eigen::Vector2d(30, 60));
  for (std::size_t i = 1; i < path.size(); ++i) {
    EXPECT_LE((path[i] - path[i - 1]).norm(), 0.5 + 1e-9);
    EXPECT_GE((path[i] - path[i - 1]).norm(), 0.2);
  }
  const std::vector<double> curvatures = Curvatures(path);
  EXPECT_NEAR(*std::max_element(curvatures.begin(), curvatures.end()), 1.0 / 6, 1e-3) << "to the right";
  EXPECT_NEAR(*std::min_element(curvatures.begin(), curvatures.end()), -1.0 / 6, 1e-3) << "to the left";
}

TEST(RoundCorners, CurvatureGrowsEvenly) {
  const std::vector<double> curvatures = Curvatures(RoundCorners({{0, 0}, {0, 40}, {25, 60}}, 8, 0.25));
  double greatest = 0;
  for (std::size_t i = 1; i < curvatures.size(); ++i)
    greatest = std::max(greatest, std::abs(curvatures[i] - curvatures[i - 1]));
  EXPECT_LT(greatest, 1.2 * 0.25 / (8 * 4)) << "over half a radius";
}

TEST(RoundCorners, ShortPiecesMakeTighterCorners) {
  const auto tightest = [](const Points& path) {
    const std::vector<double> curvatures = Curvatures(path);
    return *std::max_element(curvatures.begin(), curvatures.end());
  };
  EXPECT_NEAR(tightest(RoundCorners({{0, 0}, {0, 20}, {12.5, 20}, {12.5, 0}}, 6, 0.1)), 1.0 / 6, 1e-3)
      << "there is room for the radius, not for the whole transitions";
  EXPECT_NEAR(tightest(RoundCorners({{0, 0}, {0, 20}, {8, 20}, {8, 0}}, 6, 0.1)), 1.0 / 4, 4e-3);
}

TEST(RoundCorners, GoesStraightThroughCornersThatAreNone) {
  const Points path = RoundCorners({{0, 0}, {0, 10}, {0, 20}}, 6, 1);
  ASSERT_EQ(path.size(), 21u);
  for (std::size_t i = 0; i < path.size(); ++i)
    EXPECT_NEAR((path[i] - Eigen::Vector2d(0, static_cast<double>(i))).norm(), 0, 1e-12);
}

TEST(RoundCorners, RefusesWhatHasNoCorners) {
  EXPECT_THROW(RoundCorners({{0, 0}}, 6, 0.5), InputError);
  EXPECT_THROW(RoundCorners({{0, 0}, {0, 0}}, 6, 0.5), InputError);
  EXPECT_THROW(RoundCorners({{0, 0}, {0, 9}, {0, 1}}, 6, 0.5), InputError);
  EXPECT_THROW(RoundCorners({{0, 0}, {0, 9}}, 0, 0.5), InputError);
  EXPECT_THROW(RoundCorners({{0, 0}, {0, 9}}, 6, 0), InputError);
}

TEST(RouteLeg, CheckNamesTheField) {
  const auto refused = [](auto change) {
    return RefusedField<RouteLeg>([&](RouteLeg& leg) {
      leg.points = {{0, 0}, {0, 5}};
      change(leg);
    });
  };
  EXPECT_EQ(refused([](RouteLeg&) {}), "");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.points.pop_back(); }), "leg.points");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.points[1] = leg.points[0]; }), "leg.points");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.points[1].x() = std::nan(""); }), "leg.points");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.speed = 0; }), "leg.speed");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.wait = -1; }), "leg.wait");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.speeds = {1}; }), "leg.speeds");
  EXPECT_EQ(refused([](RouteLeg& leg) { leg.speeds = {1, -1}; }), "leg.speeds");
}

}  // namespace
}  // namespace turnscale
