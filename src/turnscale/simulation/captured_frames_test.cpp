// SPDX-License-Identifier: MIT
#include "turnscale/simulation/captured_frames.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

constexpr double kFramesPerSecond = 30;
constexpr int kTenMinutes = 18000;

std::vector<CapturedFrame> Capture(const RecorderOptions& options, int count = kTenMinutes, std::uint64_t seed = 1) {
  return CapturedFrames(options, count, kFramesPerSecond, seed);
}

TEST(CapturedFrames, AllAtTheirTimesByDefault) {
  const std::vector<CapturedFrame> frames = Capture({}, 50);
  ASSERT_EQ(frames.size(), 50u);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(frames[i].number, i);
    EXPECT_EQ(frames[i].stamp, i / kFramesPerSecond);
  }
}

TEST(CapturedFrames, StallsLoseAFewFramesEach) {
  const std::vector<CapturedFrame> frames = Capture({.stalls_per_minute = 12, .stalled_frames = 4});
  EXPECT_EQ(frames[0].number, 0);
  int stalls = 0;
  for (size_t i = 1; i < frames.size(); ++i) {
    const int step = frames[i].number - frames[i - 1].number;
    stalls += step > 1;
    EXPECT_GE(step, 1);
    EXPECT_LE(step, 9) << "two stalls in a row at most";
    EXPECT_EQ(frames[i].stamp, frames[i].number / kFramesPerSecond);
  }
  EXPECT_NEAR(stalls, 120, 33) << "three standard deviations";
  EXPECT_NEAR(static_cast<double>(kTenMinutes - frames.size()) / stalls, 2.5, 0.4);
}

TEST(CapturedFrames, JitterHasItsSizeAndKeepsTheOrder) {
  for (const double jitter : {1.0, 20.0}) {
    const std::vector<CapturedFrame> frames = Capture({.stamp_jitter_ms = jitter});
    double sum = 0;
    double squares = 0;
    for (size_t i = 1; i < frames.size(); ++i) {
      const double stray = 1e3 * (frames[i].stamp - frames[i].number / kFramesPerSecond);
      sum += stray;
      squares += stray * stray;
      EXPECT_GT(frames[i].stamp - frames[i - 1].stamp, 0.49 / kFramesPerSecond);
    }
    const auto count = static_cast<double>(frames.size());
    EXPECT_NEAR(sum / count, 0, 0.03 * jitter);
    if (jitter == 1) {
      EXPECT_NEAR(std::sqrt(squares / count), 1, 0.02);
    }
  }
}

TEST(CapturedFrames, DependOnTheSeedAndNotOnTheCount) {
  const RecorderOptions options = {.stalls_per_minute = 20, .stamp_jitter_ms = 2};
  const auto text = [](const std::vector<CapturedFrame>& frames) {
    std::vector<double> numbers;
    for (const CapturedFrame& frame : frames) numbers.insert(numbers.end(), {frame.number * 1.0, frame.stamp});
    return numbers;
  };
  const std::vector<double> first = text(Capture(options, 900));
  EXPECT_EQ(first, text(Capture(options, 900)));
  EXPECT_NE(first, text(Capture(options, 900, 2)));
  const std::vector<double> longer = text(Capture(options, 1800));
  EXPECT_EQ(first, std::vector<double>(longer.begin(), longer.begin() + static_cast<std::ptrdiff_t>(first.size())));
}

TEST(RecorderOptions, ComplaintsNameTheField) {
  EXPECT_EQ(RefusedField<RecorderOptions>([](RecorderOptions&) {}), "");
  EXPECT_EQ(RefusedField<RecorderOptions>([](RecorderOptions& o) { o.megabits_per_second = 0; }),
            "recorder.megabits_per_second");
  EXPECT_EQ(RefusedField<RecorderOptions>([](RecorderOptions& o) { o.stalls_per_minute = NAN; }),
            "recorder.stalls_per_minute");
  EXPECT_EQ(RefusedField<RecorderOptions>([](RecorderOptions& o) { o.stalled_frames = 0; }), "recorder.stalled_frames");
  EXPECT_EQ(RefusedField<RecorderOptions>([](RecorderOptions& o) { o.stamp_jitter_ms = -1; }),
            "recorder.stamp_jitter_ms");
}

}  // namespace
}  // namespace turnscale
