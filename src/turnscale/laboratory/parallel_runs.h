// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>

namespace turnscale {

/// Told how many of all runs are done, one call at a time; false asks to stop.
using RunProgress = std::function<bool(int done, int all)>;

/// Calls run(i) for i in 0...runs - 1, `jobs` at a time. What a run does must depend on i alone; then results do not
/// depend on `jobs`. Returns false where `progress` asked to stop: the runs not begun by then are left out. What a run
/// throws is thrown from here.
bool ParallelRuns(int runs, int jobs, const std::function<void(int)>& run, const RunProgress& progress = {});

/// Seed of the noise of one run among those of `seed`.
std::uint64_t SeedOfRun(std::uint64_t seed, int run);

}  // namespace turnscale
