// SPDX-License-Identifier: MIT
#include "turnscale/odometry/background.h"

#include <atomic>
#include <memory>

#include <gtest/gtest.h>
#include <opencv2/core/utility.hpp>

namespace turnscale {
namespace {

class Background : public testing::TestWithParam<int> {
 protected:
  Background() { cv::setNumThreads(GetParam()); }
  ~Background() override { cv::setNumThreads(before_); }

 private:
  int before_ = cv::getNumThreads();
};

TEST_P(Background, AResultIsTakenAtItsKeyframe) {
  DueResult<int> result;
  EXPECT_FALSE(result.TakeIfDue(100));
  result.Start(12, [] { return 7; });
  EXPECT_TRUE(result.pending());
  EXPECT_FALSE(result.TakeIfDue(11)) << "not earlier, even if it is there";
  ASSERT_NE(result.Await(), nullptr);
  EXPECT_EQ(*result.Await(), 7);
  EXPECT_FALSE(result.TakeIfDue(11));
  EXPECT_EQ(result.TakeIfDue(13), 7);
  EXPECT_FALSE(result.pending());
  EXPECT_EQ(result.Await(), nullptr);
}

TEST_P(Background, AResultMayBeWantedAtOnce) {
  DueResult<int> result;
  result.Hurry();
  result.Start(12, [] { return 7; });
  EXPECT_FALSE(result.TakeIfDue(3)) << "only work that is pending is hurried";
  result.Hurry();
  EXPECT_EQ(result.TakeIfDue(0), 7);
}

TEST_P(Background, AFailureIsThrownWhereTheResultIsTaken) {
  DueResult<int> result;
  result.Start(12, []() -> int { throw InputError("no result"); });
  EXPECT_EQ(result.Await(), nullptr);
  EXPECT_TRUE(result.pending());
  EXPECT_THROW(result.TakeIfDue(12), InputError);
  EXPECT_FALSE(result.pending());
}

TEST_P(Background, WorkRunsOnceAndMayBeMovedOnly) {
  std::atomic<int> calls = 0;
  std::future<int> result = InBackground([&calls, value = std::make_unique<int>(3)] { return *value + calls++; });
  EXPECT_EQ(result.get(), 3);
  EXPECT_EQ(calls, 1);
}

INSTANTIATE_TEST_SUITE_P(OneAndTwoThreads, Background, testing::Values(1, 2));

}  // namespace
}  // namespace turnscale
