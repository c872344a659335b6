// SPDX-License-Identifier: MIT
#include "turnscale/run/run_cost.h"

#include <chrono>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(RunCost, CostIsMeasured) {
  const RunCost of_process = CostSince({std::chrono::steady_clock::now(), 0});
  EXPECT_GT(of_process.cpu_seconds, 0);
  EXPECT_GT(of_process.peak_memory_mb, 1);
  const RunCost of_nothing = CostSince(ReadClocks());
  EXPECT_LT(of_nothing.wall_seconds, 1);
  EXPECT_LT(of_nothing.cpu_seconds, of_process.cpu_seconds) << "an earlier run costs this one nothing";
}

TEST(RunCost, LatencyIsThatOfTheMiddleAndOfTheSlowestFrames) {
  EXPECT_FALSE(LatencyOf({}));
  std::vector<double> seconds(99, 0.02);
  seconds.push_back(0.5);
  const std::optional<FrameLatency> latency = LatencyOf(seconds);
  ASSERT_TRUE(latency);
  EXPECT_DOUBLE_EQ(latency->median, 20);
  EXPECT_GE(latency->percentile_99, 20);
  EXPECT_LE(latency->percentile_99, 500);
  EXPECT_DOUBLE_EQ(latency->largest, 500);
}

}  // namespace
}  // namespace turnscale
