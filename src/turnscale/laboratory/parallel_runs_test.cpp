// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/parallel_runs.h"

#include <atomic>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(ParallelRuns, TellTheirProgressOneByOne) {
  for (const int jobs : {1, 3}) {
    std::vector<std::pair<int, int>> told;
    EXPECT_TRUE(ParallelRuns(
        4, jobs, [](int) {},
        [&](int done, int all) {
          told.emplace_back(done, all);
          return true;
        }));
    EXPECT_EQ(told, (std::vector<std::pair<int, int>>{{1, 4}, {2, 4}, {3, 4}, {4, 4}}));
  }
}

TEST(ParallelRuns, BeginNoMoreOnceTheyAreToStop) {
  for (const int jobs : {1, 3}) {
    std::atomic<int> begun = 0;
    EXPECT_FALSE(ParallelRuns(
        100, jobs, [&](int) { ++begun; }, [](int done, int) { return done < 5; }));
    EXPECT_GE(begun, 5);
    EXPECT_LT(begun, 5 + jobs);
  }
}

TEST(ParallelRuns, ThrowWhatARunThrows) {
  int begun = 0;
  const auto run = [&](int i) {
    ++begun;
    if (i == 2) throw std::runtime_error("two");
  };
  EXPECT_THROW(ParallelRuns(100, 1, run), std::runtime_error);
  EXPECT_EQ(begun, 3);
}

TEST(SeedOfRun, DiffersFromRunToRunAndFromSeedToSeed) {
  EXPECT_EQ(SeedOfRun(1, 2), SeedOfRun(1, 2));
  EXPECT_NE(SeedOfRun(1, 2), SeedOfRun(1, 3));
  EXPECT_NE(SeedOfRun(1, 2), SeedOfRun(2, 1));
}

}  // namespace
}  // namespace turnscale
