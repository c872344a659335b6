// SPDX-License-Identifier: MIT
#include "turnscale/odometry/frame_counter.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

std::string Refusal(const FrameCounter& counter, double time) {
  try {
    counter.Check(time);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(FrameCounter, NumbersFramesFromZero) {
  FrameCounter counter;
  EXPECT_EQ(counter.last_frame_time(), -HUGE_VAL);
  EXPECT_EQ(counter.Add(-3.5), 0);
  EXPECT_EQ(counter.Add(7), 1);
  EXPECT_EQ(counter.last_frame_time(), 7);
}

TEST(FrameCounter, TimeIsFiniteAndGoesOn) {
  FrameCounter counter;
  EXPECT_EQ(Refusal(counter, std::nan("")), "time nan s: has to be a finite number");
  EXPECT_EQ(Refusal(counter, 2), "");
  counter.Add(2);
  EXPECT_EQ(Refusal(counter, 2), "time 2.000000 s: has to be after the frame before");
  EXPECT_EQ(Refusal(counter, 2.1), "");
}

TEST(FrameCounter, FramesThatAreAllFarApartHaveTimesInAnotherUnit) {
  FrameCounter counter;
  for (int frame = 0; frame < 8; ++frame) {
    EXPECT_EQ(Refusal(counter, 33.0 * frame), "") << frame;
    counter.Add(33.0 * frame);
  }
  EXPECT_NE(Refusal(counter, 264).find("all frames so far are 33 s apart or more"), std::string::npos);
  EXPECT_EQ(Refusal(counter, 233), "") << "one is close to another";
}

}  // namespace
}  // namespace turnscale
