// SPDX-License-Identifier: MIT
#include "turnscale/odometry/results.h"

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(StateNames, AreReadAsTheyAreWritten) {
  for (const ScaleState state : {ScaleState::kPending, ScaleState::kObserved, ScaleState::kHeld, ScaleState::kFromRoad})
    EXPECT_EQ(ScaleStateNamed(ScaleStateName(state)), state) << ScaleStateName(state);
  for (const TrackingState state : {TrackingState::kInitializing, TrackingState::kTracked, TrackingState::kRepeated,
                                    TrackingState::kBridged, TrackingState::kUnreadable})
    EXPECT_EQ(TrackingStateNamed(TrackingStateName(state)), state) << TrackingStateName(state);
  EXPECT_EQ(ScaleStateNamed("tracked"), std::nullopt);
  EXPECT_EQ(TrackingStateNamed(""), std::nullopt);
}

}  // namespace
}  // namespace turnscale
