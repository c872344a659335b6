// SPDX-License-Identifier: MIT
#include "turnscale/calibration/usual_speed.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

void Drive(UsualSpeed& speed, double metres_per_second, double seconds) {
  for (int i = 0; i < 10 * seconds; ++i) speed.Add(0.1 * metres_per_second, 0.1);
}

TEST(UsualSpeed, IsTheSpeedThatHalfOfTheWayIsDrivenAt) {
  UsualSpeed speed;
  EXPECT_EQ(speed.value(), 0);
  Drive(speed, 5, 30);
  EXPECT_NEAR(speed.value(), 5, 1e-9);
  Drive(speed, 20, 6);
  EXPECT_NEAR(speed.value(), 5, 1e-9);
  Drive(speed, 20, 3);
  EXPECT_NEAR(speed.value(), 20, 1e-9);
}

TEST(UsualSpeed, StandingDoesNotCount) {
  UsualSpeed speed(60);
  Drive(speed, 8, 60);
  Drive(speed, 0.1, 600);
  Drive(speed, 0, 600);
  EXPECT_NEAR(speed.value(), 8, 1e-9);
}

TEST(UsualSpeed, ForgetsWhatWasLongAgo) {
  UsualSpeed all;
  UsualSpeed latest(60);
  for (UsualSpeed* speed : {&all, &latest}) {
    Drive(*speed, 30, 600);
    Drive(*speed, 5, 900);
  }
  EXPECT_NEAR(all.value(), 30, 1e-9);
  EXPECT_NEAR(latest.value(), 5, 1e-9);
}

TEST(UsualSpeed, AnyUnitWillDo) {
  UsualSpeed metres;
  UsualSpeed units;
  for (const double speed : {3.0, 7.3, 7.5, 7.7, 9.0, 2.0}) {
    metres.Add(speed, 1);
    units.Add(0.0371 * speed, 1);
  }
  EXPECT_NEAR(units.value() / metres.value(), 0.0371, 1e-12);
}

}  // namespace
}  // namespace turnscale
