// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <optional>
#include <vector>

namespace turnscale {

/// Time from an image to its pose, decoding not included, milliseconds.
struct FrameLatency {
  double median = 0;
  double percentile_99 = 0;
  double largest = 0;
};

/// Of the times of all frames, seconds; none if there are none.
std::optional<FrameLatency> LatencyOf(const std::vector<double>& seconds);

/// Cost of a run: the only part that may differ between two runs of the same input.
struct RunCost {
  double wall_seconds = 0;
  double cpu_seconds = 0;     ///< of all threads
  double peak_memory_mb = 0;  ///< resident, 2^20 bytes; of the whole process so far, earlier runs included
  std::optional<FrameLatency> latency;
};

/// The clocks of this process at a moment.
struct ProcessClocks {
  std::chrono::steady_clock::time_point wall;
  double cpu_seconds = 0;  ///< of all threads
};
ProcessClocks ReadClocks();

/// Cost since a moment, without latencies.
RunCost CostSince(const ProcessClocks& start);

}  // namespace turnscale
