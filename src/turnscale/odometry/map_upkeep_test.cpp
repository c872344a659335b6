// SPDX-License-Identifier: MIT
#include "turnscale/odometry/map_upkeep.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

constexpr int kUpkeepWindow = 30;

class Upkeep : public testing::Test {
 protected:
  Upkeep() {
    options_.turn_bundle = {.window = kUpkeepWindow, .anchors = 10};
    whole_ =
        MakeMap(MakeCarDrive({{130, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity()), {.points_per_step = 10});
  }

  Map MapOf(int keyframes) const { return MapUpTo(keyframes, whole_); }

  OdometryOptions options_;
  Map whole_;
  MountCalibration mount_{VehicleOptions()};
};

TEST_F(Upkeep, AReadjustmentIsAppliedSomeKeyframesAfterItsTurn) {
  MapUpkeep upkeep(options_);
  upkeep.StartReadjustmentIfDue(MapOf(40), mount_, true);
  Map map = MapOf(45);
  EXPECT_FALSE(upkeep.ApplyIfDue(map));
  map = MapOf(46);
  map.keyframes[39].camera_from_world.translation.x() += 0.05;
  const std::optional<AppliedReadjustment> applied = upkeep.ApplyIfDue(map);
  ASSERT_TRUE(applied);
  EXPECT_FALSE(applied->failed);
  EXPECT_LT((Centre(map.keyframes[39]) - Centre(whole_.keyframes[39])).norm(), 0.02) << "it is back at its place";
  EXPECT_EQ(applied->keyframes.first, 40 - kUpkeepWindow);
  EXPECT_EQ(applied->keyframes.end, 40);
  EXPECT_EQ(static_cast<int>(applied->factors.size()), 46 - applied->keyframes.first);
  EXPECT_EQ(applied->mount.next_keyframe(), 40);
  EXPECT_FALSE(upkeep.ApplyIfDue(map)) << "once";
}

TEST_F(Upkeep, AWindowOfNoNumbersFails) {
  MapUpkeep upkeep(options_);
  Map map = MapOf(40);
  map.keyframes[39].camera_from_world.translation.x() = std::nan("");
  const AppliedReadjustment applied = upkeep.ReadjustNow(mount_, map);
  EXPECT_TRUE(applied.failed);
  EXPECT_EQ(applied.keyframes.end, 40) << "it is not tried again";
  EXPECT_EQ(map.keyframes[38].camera_from_world.translation, whole_.keyframes[38].camera_from_world.translation);
}

TEST_F(Upkeep, WithoutATurnHalfAWindowIsReadjusted) {
  MapUpkeep upkeep(options_);
  upkeep.StartReadjustmentIfDue(MapOf(kUpkeepWindow / 2 - 1), mount_, false);
  upkeep.Hurry();
  Map map = MapOf(kUpkeepWindow / 2);
  EXPECT_FALSE(upkeep.ApplyIfDue(map));
  upkeep.StartReadjustmentIfDue(map, mount_, false);
  upkeep.Hurry();
  EXPECT_TRUE(upkeep.ApplyIfDue(map));
}

TEST_F(Upkeep, KeyframesAreReadjustedOnceUnderACorrection) {
  MapUpkeep upkeep(options_);
  Map map = MapOf(40);
  EXPECT_EQ(upkeep.ReadjustNow(mount_, map).keyframes.first, 40 - kUpkeepWindow);
  EXPECT_EQ(upkeep.ReadjustNow(mount_, map).keyframes.first, 40);
  CorrectLens(map, 0.001);
  EXPECT_EQ(upkeep.ReadjustNow(mount_, map).keyframes.first, 40) << "a small change";
  CorrectLens(map, 0.003);
  EXPECT_EQ(upkeep.ReadjustNow(mount_, map).keyframes.first, 40 - kUpkeepWindow);
}

TEST_F(Upkeep, WhatCannotChangeAnyMoreIsArchived) {
  MapUpkeep upkeep(options_);
  Map map = MapOf(100);
  EXPECT_FALSE(upkeep.ArchiveNextPart(map));
  const std::size_t landmarks = map.landmarks.size();
  const int last = upkeep.ReadjustNow(mount_, map).keyframes.final_before;
  EXPECT_EQ(last, 100 - kUpkeepWindow - 10);
  // In two parts, none of them larger than a block.
  EXPECT_EQ(upkeep.ArchiveNextPart(map)->size(), landmarks);
  EXPECT_EQ(upkeep.archive().end(), last / 2);
  upkeep.StartReadjustmentIfDue(map, mount_, true);
  upkeep.Hurry();
  EXPECT_FALSE(upkeep.ApplyIfDue(map)) << "it waits for the archive";
  EXPECT_TRUE(upkeep.ArchiveNextPart(map));
  EXPECT_EQ(upkeep.archive().end(), last);
  EXPECT_FALSE(upkeep.ArchiveNextPart(map));
  upkeep.StartReadjustmentIfDue(map, mount_, false);
  EXPECT_THROW(upkeep.ArchiveAll(map), InternalError) << "landmarks would be renumbered meanwhile";
  upkeep.Hurry();
  EXPECT_TRUE(upkeep.ApplyIfDue(map)) << "it has been due before";
  upkeep.ArchiveAll(map);
  EXPECT_EQ(upkeep.archive().end(), 100);
}

TEST_F(Upkeep, UnitsAreJudgedOnceEnoughKeyframesFollow) {
  MapUpkeep upkeep(options_);
  Map map = MapOf(20);
  upkeep.JudgeUnits(map);
  EXPECT_GT(map.keyframes[9].pixel_unit_variance, 0);
  EXPECT_EQ(map.keyframes[10].pixel_unit_variance, 0);
}

}  // namespace
}  // namespace turnscale
