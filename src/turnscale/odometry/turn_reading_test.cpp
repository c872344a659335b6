// SPDX-License-Identifier: MIT
#include "turnscale/odometry/turn_reading.h"

#include <limits>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// Keyframes a unit apart on a line.
Map Line(int keyframes) {
  Map map;
  for (int k = 0; k < keyframes; ++k) {
    map.keyframes.push_back({k, 0.1 * k, {Eigen::Quaterniond::Identity(), {0, 0, -1.0 * k}}, {}, false});
  }
  return map;
}

std::vector<PoseScale> Scales(double metres_per_unit, double own_sigma, int count) {
  PoseScale scale;
  scale.metres_per_unit = metres_per_unit;
  scale.own_sigma = own_sigma;
  return {static_cast<std::size_t>(count), scale};
}

TEST(TurnReading, WeighsATurnByWhatTheDriveSays) {
  const Map map = Line(6);
  TurnScale turn = HeldTurn({1, 3, 0.5}, 7);
  EXPECT_EQ(turn.first_step, 2);
  EXPECT_EQ(turn.last_step, 4);
  turn.distances = {1, 1, 1};
  ASSERT_TRUE(WeighSmoothed(Scales(3, 0.01, 6), map, {1, 1, 2, 2, 2, 2}, turn));
  EXPECT_DOUBLE_EQ(turn.factor, 1.5) << "the map's unit is half of the drive's";
  EXPECT_EQ(turn.sigma, 0.01);
  EXPECT_TRUE(turn.distances.empty()) << "lengths of an earlier recovery no longer count";
}

TEST(TurnReading, ATurnStaysAsItIsWhereTheDriveSaysNothing) {
  const Map map = Line(6);
  const std::vector<double> units(6, 1.0);
  TurnScale turn = HeldTurn({1, 3, 0.5}, 7);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<PoseScale>& scales :
       {std::vector<PoseScale>(), Scales(kNaN, 0.01, 6), Scales(3, kNaN, 6), Scales(3, 0, 6)}) {
    EXPECT_FALSE(WeighSmoothed(scales, map, units, turn));
    EXPECT_EQ(turn.factor, 7);
    EXPECT_EQ(turn.sigma, 0);
  }
}

}  // namespace
}  // namespace turnscale
