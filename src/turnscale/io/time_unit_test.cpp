// SPDX-License-Identifier: MIT
#include "turnscale/io/time_unit.h"

#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Of that unit of so many seconds, from `begin` seconds on.
std::vector<double> Times(double unit, double begin, double step) {
  std::vector<double> times;
  for (int i = 0; i < 50; ++i) times.push_back((begin + i * step) / unit);
  return times;
}

TEST(TimeUnit, SecondsStaySeconds) {
  for (const double begin : {-10.0, 0.0, 1e5, 1.4e9})
    for (const double step : {0.005, 0.1, 1.0, 30.0}) EXPECT_EQ(SecondsPerUnit(Times(1, begin, step)), 1);
  EXPECT_EQ(SecondsPerUnit({}), 1);
  EXPECT_EQ(SecondsPerUnit({1.4e9}), 1);
}

TEST(TimeUnit, ClocksSince1970) {
  for (const double unit : {1e-3, 1e-6, 1e-9}) {
    for (const double step : {0.005, 0.1, 1.0})
      EXPECT_EQ(SecondsPerUnit(Times(unit, 1.4e9, step)), unit) << unit << " " << step;
    EXPECT_EQ(SecondsPerUnit({1.4e9 / unit}), unit) << unit;
  }
}

TEST(TimeUnit, ClocksSinceTheirStart) {
  for (const double begin : {3600.0, 2e5, 2e6}) {
    EXPECT_EQ(SecondsPerUnit(Times(1e-9, begin, 1.0 / 30)), 1e-9) << begin;
    EXPECT_EQ(SecondsPerUnit(Times(1e-6, begin, 1.0 / 30)), 1e-6) << begin;
    for (const double rate : {100.0, 200.0, 400.0, 600.0}) {
      EXPECT_EQ(SecondsPerUnit(Times(1e-9, begin, 1 / rate)), 1e-9) << begin << " " << rate;
      EXPECT_TRUE(AreNanoseconds(Times(1e-9, begin, 1 / rate)));
    }
  }
  EXPECT_EQ(SecondsPerUnit(Times(1e-9, 0, 0.1)), 1e-9);
  EXPECT_EQ(SecondsPerUnit(Times(1e-6, 0, 0.1)), 1e-6);
}

TEST(TimeUnit, MillisecondsFromZeroAreRefused) {
  EXPECT_NO_THROW(RefuseSparseTimes("a", Times(1, 0, 8)));
  EXPECT_NO_THROW(RefuseSparseTimes("a", {}));
  try {
    RefuseSparseTimes("times.txt", Times(1e-3, 0, 0.1));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "times.txt: half of the times are 100 s apart or more; are they milliseconds, or numbers of frames? Give "
        "seconds");
  }
}

TEST(TimeUnit, NanosecondsOfAFormatAreTold) {
  EXPECT_TRUE(AreNanoseconds(Times(1e-9, 0, 0.001)));
  EXPECT_TRUE(AreNanoseconds({5}));
  EXPECT_FALSE(AreNanoseconds(Times(1e-6, 0, 0.033)));
  EXPECT_FALSE(AreNanoseconds(Times(1e-3, 1.4e9, 0.1)));
}

TEST(TimeUnit, AllTimesAreConverted) {
  const std::vector<double> seconds = InSeconds({1.4e15, 1.4e15 + 1e5});
  EXPECT_EQ(seconds[0], 1.4e9);
  EXPECT_NEAR(seconds[1] - seconds[0], 0.1, 1e-6);
}

}  // namespace
}  // namespace turnscale
