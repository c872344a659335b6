// SPDX-License-Identifier: MIT
#include "turnscale/road/road_patches.h"

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/road/synthetic_road.h"

namespace turnscale {
namespace {

constexpr double kPatchHeight = 1.5;

// Level, so that the epipole is the principal point.
RoadViews LevelViews(const SyntheticRoad& road = {.height = kPatchHeight}) {
  CameraModel camera;
  camera.pinhole = {.fx = 360, .fy = 360, .cx = 320, .cy = 100};
  camera.width = 640;
  camera.height = 240;
  return ViewRoad(camera, road, {0, 0, 0});
}

RoadSurface FlatRoad(double height) { return {{0, 1 / height, 0}, 0}; }

cv::Point CentreOf(const RoadViews& views, const RoadPatch& patch, int size) {
  const Eigen::Vector2d pixel = *views.camera.Project(patch.ray) * (size == 0 ? 1.0 : 0.5);
  return {cvRound(pixel.x()), cvRound(pixel.y())};
}

TEST(RoadPatches, LieInTheLaneAhead) {
  const RoadPatchOptions options;
  const RoadViews views = LevelViews();
  for (const int size : {0, 1}) {
    const std::vector<RoadPatch> patches = SelectRoadPatches(options, views.Pair(), views.region, size);
    EXPECT_GT(patches.size(), 60u) << size;
    EXPECT_LE(patches.size(), static_cast<size_t>(options.rows * options.columns));
    // Cells are boxes in the image around those of the lane: their corners lie outside of it by a little.
    constexpr double kCorner = 1.3;
    for (const RoadPatch& patch : patches) {
      const double ahead = 1 / patch.ray.y();  // heights
      EXPECT_GT(ahead, options.nearest / kCorner);
      EXPECT_LT(ahead, options.farthest * kCorner);
      EXPECT_LT(std::abs(patch.ray.x() * ahead), options.half_width * kCorner);
    }
  }
}

TEST(RoadPatches, FollowThePathAhead) {
  RoadViews views = LevelViews();
  const auto mean_side = [&] {
    double sum = 0;
    const std::vector<RoadPatch> patches = SelectRoadPatches({}, views.Pair(), views.region, 0);
    for (const RoadPatch& patch : patches) sum += patch.ray.x() / patch.ray.y() / static_cast<double>(patches.size());
    return sum;
  };
  const double straight = mean_side();
  views.region.direction = 0.05;
  const double to_the_right = mean_side();
  views.region.direction = 0;
  views.region.curvature = -0.02;
  const double curved_left = mean_side();
  EXPECT_NEAR(straight, 0, 0.1);
  EXPECT_GT(to_the_right, 0.1);
  EXPECT_LT(curved_left, -0.05);
}

TEST(RoadPatches, HaveTheContrastAskedFor) {
  const RoadViews views = LevelViews({.height = kPatchHeight, .contrast = 0.2});
  RoadPatchOptions options;
  const double side = 2 * options.half_size + 1;
  const size_t before = SelectRoadPatches(options, views.Pair(), views.region, 0).size();
  options.least_contrast = 4;
  const std::vector<RoadPatch> patches = SelectRoadPatches(options, views.Pair(), views.region, 0);
  EXPECT_LT(patches.size(), before);
  for (const RoadPatch& patch : patches) EXPECT_GE(patch.contrast, 4 * side);
  options.least_contrast = 60;
  EXPECT_TRUE(SelectRoadPatches(options, views.Pair(), views.region, 0).empty());
  const RoadViews even = LevelViews({.height = kPatchHeight, .contrast = 0});
  EXPECT_TRUE(SelectRoadPatches({}, even.Pair(), even.region, 0).empty());
}

// A line along the motion shows no motion, however bright it is.
TEST(RoadPatches, AreWhereTheGrayLevelChangesAlongTheMotion) {
  RoadViews views = LevelViews({.height = kPatchHeight, .contrast = 0});
  const auto middle = static_cast<int>(views.camera.pinhole.cx);
  for (int y = 0; y < views.current.gray.rows; ++y) views.current.gray.row(y).setTo(y / 4 % 2 == 0 ? 100 : 120);
  views.current.gray.colRange(middle - 2, middle + 3).setTo(160);
  const std::vector<RoadPatch> patches = SelectRoadPatches({}, views.Pair(), views.region, 0);
  int beside_line = 0;
  for (const RoadPatch& patch : patches) {
    const int aside = std::abs(CentreOf(views, patch, 0).x - middle);
    EXPECT_GT(aside, 2) << "on the line";
    beside_line += aside < 12 ? 1 : 0;
  }
  EXPECT_GT(beside_line, 5);
}

TEST(RoadPatches, CoverNoMaskedPixel) {
  const RoadViews views = LevelViews();
  const RoadPatchOptions options;
  for (const int size : {0, 1}) {
    RoadPair pair = views.Pair();
    const size_t all = SelectRoadPatches(options, pair, views.region, size).size();
    pair.mask = cv::Mat(views.camera.height, views.camera.width, CV_8UC1, cv::Scalar(255));
    EXPECT_EQ(SelectRoadPatches(options, pair, views.region, size).size(), all);
    // Thin lines, between which no centre would be masked.
    for (int x = 0; x < pair.mask.cols; x += 60) pair.mask.col(x).setTo(0);
    const std::vector<RoadPatch> patches = SelectRoadPatches(options, pair, views.region, size);
    EXPECT_GT(patches.size(), all / 4);
    EXPECT_LT(patches.size(), all);
    const int reach = options.half_size * (size == 0 ? 1 : 2);
    for (const RoadPatch& patch : patches) {
      const cv::Point centre = CentreOf(views, patch, 0);
      const cv::Rect covered(centre.x - reach, centre.y - reach, 2 * reach + 1, 2 * reach + 1);
      EXPECT_EQ(cv::countNonZero(pair.mask(covered)), covered.area());
    }
  }
}

TEST(RoadPatches, MatchNothingThatIsMaskedInTheEarlierImage) {
  const RoadViews views = LevelViews();
  const std::vector<RoadPatch> patches = SelectRoadPatches({}, views.Pair(), views.region, 0);
  const RoadSurface road = FlatRoad(kPatchHeight);
  int matched = 0;
  for (const RoadPatch& patch : patches) {
    if (!MatchPatch({}, views.Pair(), patch, road, 0)) continue;
    ++matched;
    const Eigen::Vector3d point = patch.ray / road.InverseDepth(patch.ray);
    const Eigen::Vector2d earlier = *views.camera.Project(views.earlier_from_current * point);
    RoadPair pair = views.Pair();
    pair.mask = cv::Mat(views.camera.height, views.camera.width, CV_8UC1, cv::Scalar(255));
    pair.mask.at<uchar>(cvRound(earlier.y()) - 2, cvRound(earlier.x()) + 2) = 0;
    EXPECT_FALSE(MatchPatch({}, pair, patch, road, 0)) << "off its centre";
  }
  EXPECT_GT(matched, 60);
}

TEST(RoadPatches, MatchOnTheRoadAndPointToItFromBesides) {
  const RoadViews views = LevelViews();
  const std::vector<RoadPatch> patches = SelectRoadPatches({}, views.Pair(), views.region, 0);
  std::vector<double> correlations;
  int towards = 0;
  int matched = 0;
  for (const RoadPatch& patch : patches) {
    const auto on_road = MatchPatch({}, views.Pair(), patch, FlatRoad(kPatchHeight), 0);
    const auto below = MatchPatch({}, views.Pair(), patch, FlatRoad(1.03 * kPatchHeight), 0);
    if (!on_road || !below) continue;
    ++matched;
    correlations.push_back(on_road->correlation);
    EXPECT_LT(std::abs(on_road->inverse_depth_change), 6 * std::sqrt(on_road->variance));
    // Nearer than on a surface that is too low.
    towards += below->inverse_depth_change > 0 ? 1 : 0;
  }
  ASSERT_GT(matched, 60);
  double mean = 0;
  for (const double correlation : correlations) mean += correlation / matched;
  EXPECT_GT(mean, 0.9);
  EXPECT_GT(towards, 0.9 * matched);
}

TEST(RoadSurface, DerivativesAreThoseOfTheInverseDepth) {
  const RoadSurface surface = {{0.02, 0.6, -0.01}, 0.004};
  const Eigen::Vector3d ray(0.1, 0.3, 1);
  const Eigen::Vector4d by = surface.ByParameters(ray);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 4; ++i) {
    RoadSurface moved = surface;
    (i < 3 ? moved.plane[i] : moved.vertical_curvature) += kStep;
    EXPECT_NEAR((moved.InverseDepth(ray) - surface.InverseDepth(ray)) / kStep, by[i], 1e-5) << i;
  }
}

}  // namespace
}  // namespace turnscale
