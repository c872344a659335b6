// SPDX-License-Identifier: MIT
#include "turnscale/report/path_thinning.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// A long straight, half a turn of 8 m radius, and a wait.
Trajectory LongDrive() {
  Trajectory drive;
  for (int i = 0; i < 30000; ++i) {
    const double turned = std::clamp((i - 20000) * M_PI / 100, 0.0, M_PI);
    const double along = 0.5 * std::min(i, 20000);
    drive.push_back(
        {0.1 * i, {RotationFromVector({0, turned, 0}), {8 * (1 - std::cos(turned)), 0, along + 8 * std::sin(turned)}}});
  }
  return drive;
}

TEST(PathThinning, KeepsCurvesRound) {
  const Trajectory drive = LongDrive();
  const std::vector<int> places = ThinPath(drive, 3000, {777});
  EXPECT_LE(places.size(), 3003u);
  EXPECT_GE(places.size(), 900u);
  EXPECT_EQ(places.front(), 0);
  EXPECT_EQ(places.back(), 29999);
  EXPECT_TRUE(std::is_sorted(places.begin(), places.end()));
  EXPECT_TRUE(std::binary_search(places.begin(), places.end(), 777));
  double worst = 0;
  for (size_t k = 1; k < places.size(); ++k) {
    const Eigen::Vector3d a = drive[places[k - 1]].world_from_camera.translation;
    const Eigen::Vector3d chord = drive[places[k]].world_from_camera.translation - a;
    for (int i = places[k - 1]; i < places[k]; ++i) {
      const Eigen::Vector3d off = drive[i].world_from_camera.translation - a;
      const Eigen::Vector3d axis = chord.norm() > 0 ? Eigen::Vector3d(chord.normalized()) : Eigen::Vector3d::Zero();
      worst = std::max(worst, (off - off.dot(axis) * axis).norm());
    }
  }
  EXPECT_LT(worst, 0.02) << "metres between the thinned path and the whole";
}

TEST(PathThinning, ShortPathsStayWhole) {
  const Trajectory drive = LongDrive();
  EXPECT_EQ(ThinPath({drive.begin(), drive.begin() + 50}, 100).size(), 50u);
  EXPECT_TRUE(ThinPath({}, 100).empty());
}

}  // namespace
}  // namespace turnscale
