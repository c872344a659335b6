// SPDX-License-Identifier: MIT
#include "turnscale/run/run_cost.h"

#include <sys/resource.h>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

rusage Usage() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

}  // namespace

std::optional<FrameLatency> LatencyOf(const std::vector<double>& seconds) {
  if (seconds.empty()) return std::nullopt;
  return FrameLatency{1e3 * Median(seconds), 1e3 * Quantile(seconds, 0.99), 1e3 * Quantile(seconds, 1)};
}

ProcessClocks ReadClocks() {
  const rusage usage = Usage();
  return {std::chrono::steady_clock::now(), Seconds(usage.ru_utime) + Seconds(usage.ru_stime)};
}

RunCost CostSince(const ProcessClocks& start) {
  const ProcessClocks now = ReadClocks();
  RunCost cost;
  cost.wall_seconds = std::chrono::duration<double>(now.wall - start.wall).count();
  cost.cpu_seconds = now.cpu_seconds - start.cpu_seconds;
  cost.peak_memory_mb = static_cast<double>(Usage().ru_maxrss) / 1024.0;
  return cost;
}

}  // namespace turnscale
