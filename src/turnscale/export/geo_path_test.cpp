// SPDX-License-Identifier: MIT
#include "turnscale/export/geo_path.h"

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/export/test_results.h"

namespace turnscale {
namespace {

TEST(GeoPath, HeadingIsClockwiseFromNorth) {
  const Eigen::Vector3d ahead(0, 10, 1);
  const Eigen::Vector3d right(10, 0, 0);
  EXPECT_LT((EastNorthUp(ahead, 0) - Eigen::Vector3d(0, 10, 1)).norm(), 1e-12);
  EXPECT_LT((EastNorthUp(ahead, M_PI / 2) - Eigen::Vector3d(10, 0, 1)).norm(), 1e-12);
  EXPECT_LT((EastNorthUp(right, M_PI / 2) - Eigen::Vector3d(0, -10, 0)).norm(), 1e-12);
}

TEST(GeoPath, ThePathBeginsAtTheOrigin) {
  const ResultFolder results = TestResults(100);
  const std::vector<LevelPlace> path = LevelPath(results, "out");
  ASSERT_EQ(path.size(), 100u);
  EXPECT_EQ(path[0].position.norm(), 0);
  EXPECT_GT(path[10].position.y(), 9) << "ahead";
  EXPECT_GT(path[99].position.x(), 1) << "a curve to the right";
  EXPECT_FALSE(path[0].speed);
  EXPECT_EQ(path[5].speed->speed, 10);
  const Placement placement{{49, 8, 0}, 0.5};
  const std::vector<GeoPlace> all = PlaceOnEarth(path, placement);
  EXPECT_EQ(all.size(), 100u);
  EXPECT_NEAR(all[0].point.latitude, 49, 1e-12);
  const std::vector<GeoPlace> few = PlaceOnEarth(path, placement, 1);
  ASSERT_EQ(few.size(), 11u) << "every second, and the last";
  EXPECT_NEAR(few[1].time, 1, 1e-9);
  EXPECT_NEAR(few.back().time, 9.9, 1e-9);
}

TEST(GeoPath, NeedsMetres) {
  ResultFolder results = TestResults(10);
  results.speeds.clear();
  EXPECT_EQ(LevelPath(results, "out").size(), 10u) << "results of a version that wrote no speeds";
  results.metric = false;
  EXPECT_THROW(LevelPath(results, "out"), InputError);
  EXPECT_THROW(LevelPath({}, "out"), InputError);
}

}  // namespace
}  // namespace turnscale
