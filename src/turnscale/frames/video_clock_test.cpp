// SPDX-License-Identifier: MIT
#include "turnscale/frames/video_clock.h"

#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

using Stamps = std::vector<std::optional<double>>;

std::vector<double> Times(VideoClock clock, const Stamps& stamps) {
  std::vector<double> times;
  for (const auto& stamp : stamps) times.push_back(clock.Next(stamp));
  return times;
}

void ExpectTimes(const VideoClock& clock, const Stamps& stamps, const std::vector<double>& expected) {
  const std::vector<double> times = Times(clock, stamps);
  ASSERT_EQ(times.size(), expected.size());
  for (size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], expected[i], 1e-9) << "frame " << i;
}

TEST(VideoClock, StampsCountFromTheFirstFrame) { ExpectTimes({10, 1e-3}, {1.4, 1.5, 1.73, 1.8}, {0, 0.1, 0.33, 0.4}); }

TEST(VideoClock, AConstantRateIsExactThoughStampsAreRounded) {
  const Stamps milliseconds = {0.0, 0.033, 0.067, 0.1, 0.133, 0.167};
  const std::vector<double> times = Times({30, 1e-3}, milliseconds);
  for (size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i], static_cast<double>(i) / 30) << i;
  ExpectTimes({30, 1e-3}, {0.0, 0.036, 0.1}, {0, 0.036, 0.1});
}

TEST(VideoClock, WithoutStampsTheRateTells) {
  const std::vector<double> times = Times({25, 1e-3}, {{}, {}, {}, {}});
  for (size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i], static_cast<double>(i) / 25);
  ExpectTimes({10, 1e-3}, {1.0, {}, 1.2, 1.3}, {0, 0.1, 0.2, 0.3});
  ExpectTimes({10, 1e-3}, {{}, {}, 7.0, 7.1}, {0, 0.1, 0.2, 0.3});
}

TEST(VideoClock, ARepeatedStampIsPassedOver) {
  ExpectTimes({10, 1e-3}, {0.0, 0.1, 0.1, 0.2, 0.3}, {0, 0.1, 0.15, 0.2, 0.3});
  ExpectTimes({10, 1e-3}, {0.0, 0.2, 0.1, 0.3}, {0, 0.2, 0.25, 0.3});
  // A stamp for each two frames: the times stay with the stamps.
  ExpectTimes({20, 1e-3}, {0.0, 0.0, 0.1, 0.1, 0.2, 0.2}, {0, 0.025, 0.1, 0.125, 0.2, 0.225});
}

TEST(VideoClock, StampsThatStartAnewContinue) {
  ExpectTimes({10, 1e-3}, {5.0, 5.1, 0.0, 0.1, 0.2}, {0, 0.1, 0.2, 0.3, 0.4});
}

TEST(VideoClock, StampsThatStandStillBecomeTheRate) {
  VideoClock clock(10, 1e-3);
  double before = clock.Next(3.0);
  for (int i = 1; i < 200; ++i) {
    const double time = clock.Next(3.0);
    EXPECT_GT(time, before);
    before = time;
  }
  EXPECT_NEAR(before, 19.9, 0.5);
}

}  // namespace
}  // namespace turnscale
