// SPDX-License-Identifier: MIT
#include "turnscale/road/road_plane.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/road/synthetic_road.h"

namespace turnscale {
namespace {

constexpr double kTrueHeight = 1.5;

CameraModel Camera() {
  CameraModel camera;
  camera.pinhole = {.fx = 360, .fy = 360, .cx = 319.5, .cy = 140};
  camera.width = 640;
  camera.height = 240;
  return camera;
}

CameraModel Fisheye() {
  CameraModel camera = Camera();
  camera.pinhole.fx = camera.pinhole.fy = 300;
  camera.lens = LensModel::kEquidistant;
  camera.distortion = {-0.02, 0.004, 0, 0, 0};
  return camera;
}

TEST(RoadPlane, HeightIsThatOfTheCamera) {
  for (const Eigen::Vector3d& mount :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(5, -6, 2), Eigen::Vector3d(-8, -3, -2)}) {
    const RoadViews views = ViewRoad(Camera(), {}, mount);
    const auto road = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
    ASSERT_TRUE(road) << mount.transpose();
    EXPECT_NEAR(road->height / kTrueHeight, 1, 0.008) << mount.transpose();
    EXPECT_LT(std::abs(road->height / kTrueHeight - 1), 4 * road->sigma);
    EXPECT_LT(road->sigma, 0.02);
    EXPECT_GT(road->share, 0.8);
    EXPECT_NEAR(road->normal.dot(views.region.level_from_camera.row(1)), 1, 1e-4);
  }
}

/// The same images with another motion: a small rotation follows it, and its unit vector of translation changes. The
/// region follows the direction of travel.
RoadViews WithMotion(RoadViews views, const Eigen::Vector3d& turn, const Eigen::Vector3d& aside) {
  RigidTransform& motion = views.earlier_from_current;
  const double travel = motion.translation.norm();
  const Eigen::Vector3d direction = (motion.translation / travel + aside).normalized();
  motion = {RotationFromVector(turn) * motion.rotation, travel * direction};
  const Eigen::Vector3d forward = motion.rotation.conjugate() * direction;
  const Eigen::Vector3d right = views.region.level_from_camera.row(0);
  const Eigen::Vector3d down = forward.cross(right).normalized();
  views.region.level_from_camera << down.cross(forward).transpose(), down.transpose(), forward.transpose();
  return views;
}

// Another motion also moves the region by fractions of a pixel, so that other patches are selected: what is left of the
// error is the scatter of fits.
TEST(RoadPlane, DerivativesByTheMotionCorrectTheHeight) {
  const std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> changes = {
      {{0, 0, 0}, {0, 0.004, 0}},       {{0, 0, 0}, {0, -0.004, 0}},        {{0.003, 0, 0}, {0, 0.004, 0}},
      {{-0.003, 0, 0}, {0, -0.004, 0}}, {{0.003, 0.003, 0}, {0, 0.004, 0}}, {{0, -0.003, 0.003}, {0.004, -0.004, 0}}};
  for (const CameraModel& camera : {Camera(), Fisheye()}) {
    double before = 0;
    double after = 0;
    for (const double travel : {0.7, 0.9, 1.4, 2.5}) {
      const RoadViews views = ViewRoad(camera, {}, {2, -4, 1}, travel);
      const auto right = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
      ASSERT_TRUE(right);
      for (const auto& [turn, aside] : changes) {
        const RoadViews other = WithMotion(views, turn, aside);
        const auto wrong = FitRoadPlane({}, other.Pair(), other.region, kTrueHeight);
        ASSERT_TRUE(wrong);
        const double error = std::log(wrong->height / right->height);
        const double corrected = error - wrong->by_rotation.dot(turn) - wrong->by_direction.dot(aside);
        before += error * error;
        after += corrected * corrected;
      }
    }
    EXPECT_LT(std::sqrt(after / before), 0.4);
  }
}

TEST(RoadPlane, IsFoundFromFifteenPercentOff) {
  const RoadViews views = ViewRoad(Camera(), {}, {2, -4, 1});
  const auto at_truth = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
  ASSERT_TRUE(at_truth);
  for (const double start : {0.87, 1.15}) {
    const auto road = FitRoadPlane({}, views.Pair(), views.region, start * kTrueHeight);
    ASSERT_TRUE(road) << start;
    EXPECT_NEAR(road->height, at_truth->height, 0.01) << start;
  }
}

TEST(RoadPlane, IsFoundWithoutAStart) {
  for (const double travel : {0.4, 1.0, 2.0}) {
    const RoadViews views = ViewRoad(Camera(), {}, {0, -4, 0}, travel);
    const auto road = FindRoadPlane({}, views.Pair(), views.region, 0.2 * travel, 10 * travel);
    ASSERT_TRUE(road) << travel;
    EXPECT_NEAR(road->height / kTrueHeight, 1, 0.01) << travel;
  }
}

TEST(RoadPlane, HeightIsInTheUnitOfTheMotion) {
  RoadViews views = ViewRoad(Camera(), {}, {0, -4, 0});
  const auto metres = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
  views.earlier_from_current.translation *= 0.07;
  const auto units = FitRoadPlane({}, views.Pair(), views.region, 0.07 * kTrueHeight);
  ASSERT_TRUE(metres && units);
  EXPECT_NEAR(units->height / metres->height, 0.07, 1e-9);
  EXPECT_NEAR(units->sigma, metres->sigma, 1e-9);
}

TEST(RoadPlane, SeesThroughAFisheye) {
  const RoadViews views = ViewRoad(Fisheye(), {}, {0, -5, 0});
  const auto road = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
  ASSERT_TRUE(road);
  EXPECT_NEAR(road->height / kTrueHeight, 1, 0.01);
}

TEST(RoadPlane, BrightnessAndContrastMayChange) {
  const Shade darker = [](int, int, double level) { return 0.6 * level + 15; };
  const RoadViews views = ViewRoad(Camera(), {}, {0, -4, 0}, 0.9, darker);
  const auto road = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
  ASSERT_TRUE(road);
  EXPECT_NEAR(road->height / kTrueHeight, 1, 0.006);
}

// A shadow of the car, or its bonnet: the same pixels in both images.
TEST(RoadPlane, WhatMovesAlongTakesNoPart) {
  const Shade shadow = [](int x, int y, double level) {
    const bool inside = x > 230 && x < 330 && y > 180;
    return inside ? 0.5 * level * (NoiseAt(x / 6.0, y / 6.0, 7) + 0.3) : level;
  };
  const RoadViews views = ViewRoad(Camera(), {}, {0, -4, 0}, 0.9, shadow, shadow);
  const auto road = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
  ASSERT_TRUE(road);
  EXPECT_NEAR(road->height / kTrueHeight, 1, 0.012);
}

TEST(RoadPlane, KerbsAreNotTheRoad) {
  const RoadViews views = ViewRoad(Camera(), {.half_width = 1.1, .kerb = 0.15}, {0, -4, 0});
  const auto road = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
  ASSERT_TRUE(road);
  EXPECT_NEAR(road->height / kTrueHeight, 1, 0.012);
}

// Crests and dips: a plane fitted to what lies ahead is not that below the camera.
TEST(RoadPlane, VerticalCurvatureDoesNotChangeTheHeight) {
  constexpr double kTravel = 0.9;
  RoadPlaneOptions flat;
  flat.vertical_curvature_sigma = 1e-9;
  for (const double curvature : {0.003, -0.003}) {  // rad per height
    const RoadViews views =
        ViewRoad(Camera(), {.vertical_curvature = curvature / kTrueHeight, .level_at = kTravel}, {0, -4, 0}, kTravel);
    const auto road = FitRoadPlane({}, views.Pair(), views.region, kTrueHeight);
    const auto without = FitRoadPlane(flat, views.Pair(), views.region, kTrueHeight);
    ASSERT_TRUE(road && without) << curvature;
    EXPECT_NEAR(road->height / kTrueHeight, 1, 0.01) << curvature;
    EXPECT_GT(std::abs(std::log(without->height / kTrueHeight)), 0.02) << curvature;
    EXPECT_GT(road->sigma, without->sigma) << "the curvature is estimated too";
  }
}

TEST(RoadPlane, ImagesOfNoRoadGiveNone) {
  const RoadViews flat = ViewRoad(Camera(), {.contrast = 0}, {0, -4, 0});
  EXPECT_FALSE(FitRoadPlane({}, flat.Pair(), flat.region, kTrueHeight));
  EXPECT_FALSE(FindRoadPlane({}, flat.Pair(), flat.region, 0.2, 9));
  Random random(3);
  const Shade noise = [&](int, int, double) { return 255 * random.Uniform(0, 1); };
  const RoadViews snow = ViewRoad(Camera(), {}, {0, -4, 0}, 0.9, noise, noise);
  EXPECT_FALSE(FitRoadPlane({}, snow.Pair(), snow.region, kTrueHeight));
  EXPECT_FALSE(FindRoadPlane({}, snow.Pair(), snow.region, 0.2, 9));
}

TEST(RoadPlane, MaskedPixelsTakeNoPart) {
  const RoadViews views = ViewRoad(Camera(), {}, {0, -4, 0});
  RoadPair pair = views.Pair();
  pair.mask = cv::Mat::zeros(240, 640, CV_8UC1);
  EXPECT_FALSE(FitRoadPlane({}, pair, views.region, kTrueHeight));
}

// Of normal noise in the images the stated sigma is about that of the height.
TEST(RoadPlane, SigmaIsThatOfNoisyImages) {
  RoadPlaneOptions options;
  options.unevenness = 0;
  std::vector<double> deviations;
  for (int seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const Shade noise = [&](int, int, double level) { return level + 3 * random.Gaussian(); };
    const RoadViews views = ViewRoad(Camera(), {.contrast = 0.3}, {0, -4, 0}, 0.9, noise, noise);
    const auto road = FitRoadPlane(options, views.Pair(), views.region, kTrueHeight);
    ASSERT_TRUE(road) << seed;
    deviations.push_back(std::log(road->height / kTrueHeight) / road->sigma);
  }
  double squares = 0;
  for (const double deviation : deviations) squares += deviation * deviation / static_cast<double>(deviations.size());
  EXPECT_LT(std::sqrt(squares), 1.6);
  EXPECT_GT(std::sqrt(squares), 0.3);
}

TEST(RoadPlaneOptions, RefusesSenselessValues) {
  const auto refused = [](auto change) { return RefusedField<RoadPlaneOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.pitch_sigma = 0; }), "pitch_sigma_deg");
  EXPECT_EQ(refused([](auto& o) { o.roll_sigma = 2; }), "roll_sigma_deg");
  EXPECT_EQ(refused([](auto& o) { o.vertical_curvature_sigma = 0; }), "vertical_curvature_sigma");
  EXPECT_EQ(refused([](auto& o) { o.unevenness = -1; }), "unevenness");
  EXPECT_EQ(refused([](auto& o) { o.min_correlation = 1; }), "min_correlation");
  EXPECT_EQ(refused([](auto& o) { o.min_patches = 2; }), "min_patches");
  EXPECT_EQ(refused([](auto& o) { o.min_share = 0; }), "min_share");
  EXPECT_EQ(refused([](auto& o) { o.patches.farthest = 1; }), "farthest");
  EXPECT_EQ(refused([](auto& o) { o.patches.half_size = 1; }), "half_size");
}

}  // namespace
}  // namespace turnscale
