// SPDX-License-Identifier: MIT
#include "turnscale/base/parallel.h"

#include <atomic>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(Parallel, CallsEachIndexOnce) {
  for (const int threads : {1, 2, 5}) {
    std::vector<std::atomic<int>> calls(1000);
    ForEachIndex(1000, threads, [&](int i) { ++calls[i]; });
    for (const std::atomic<int>& count : calls) EXPECT_EQ(count, 1);
  }
  ForEachIndex(0, 2, [](int) { FAIL(); });
}

TEST(Parallel, ThrowsOnWhatTheWorkThrows) {
  for (const int threads : {1, 3}) {
    std::atomic<int> calls = 0;
    const auto work = [&](int i) {
      ++calls;
      if (i == 50) throw std::runtime_error("fifty");
    };
    EXPECT_THROW(ForEachIndex(100, threads, work), std::runtime_error);
    if (threads == 1) {
      EXPECT_EQ(calls, 51);
    }
  }
}

}  // namespace
}  // namespace turnscale
