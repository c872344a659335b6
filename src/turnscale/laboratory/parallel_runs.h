// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>

#include "turnscale/base/parallel.h"
#include "turnscale/base/random.h"

namespace turnscale {

/// Told how many of all runs are done, one call at a time; false asks to stop.
using RunProgress = std::function<bool(int done, int all)>;

/// Calls run(i) for i in 0...runs - 1, `jobs` at a time. What a run does must depend on i alone; then results do not
/// depend on `jobs`. Returns false where `progress` asked to stop: the runs not begun by then are left out. What a run
/// throws is thrown from here.
inline bool ParallelRuns(int runs, int jobs, const std::function<void(int)>& run, const RunProgress& progress = {}) {
  std::atomic<bool> stopped = false;
  std::mutex mutex;
  int done = 0;
  ForEachIndex(runs, jobs, [&](int i) {
    if (stopped) return;
    run(i);
    const std::scoped_lock lock(mutex);
    if (progress && !progress(++done, runs)) stopped = true;
  });
  return !stopped;
}

/// Seed of the noise of one run among those of `seed`.
inline std::uint64_t SeedOfRun(std::uint64_t seed, int run) {
  return Hash(Hash(seed) + static_cast<std::uint64_t>(run));
}

}  // namespace turnscale
