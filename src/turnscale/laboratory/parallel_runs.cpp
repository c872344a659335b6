// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/parallel_runs.h"

#include <atomic>
#include <mutex>

#include "turnscale/base/parallel.h"
#include "turnscale/base/random.h"

namespace turnscale {

bool ParallelRuns(int runs, int jobs, const std::function<void(int)>& run, const RunProgress& progress) {
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

std::uint64_t SeedOfRun(std::uint64_t seed, int run) { return Hash(Hash(seed) + static_cast<std::uint64_t>(run)); }

}  // namespace turnscale
