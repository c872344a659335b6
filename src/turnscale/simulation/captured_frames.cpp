// SPDX-License-Identifier: MIT
#include "turnscale/simulation/captured_frames.h"

#include <algorithm>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// A stamp strays by this part of an interval at most, so that stamps stay in order.
constexpr double kLargestStray = 0.25;

void RefuseUnless(bool holds, const char* name, double value, const char* range) {
  if (!holds) throw InputError(fmt::format("recorder.{}: is {}; it has to be in {}", name, value, range));
}

}  // namespace

void RecorderOptions::Check() const {
  RefuseUnless(megabits_per_second >= 0.01 && megabits_per_second <= 1000, "megabits_per_second", megabits_per_second,
               "0.01...1000");
  RefuseUnless(stalls_per_minute >= 0 && stalls_per_minute <= 600, "stalls_per_minute", stalls_per_minute, "0...600");
  RefuseUnless(stalled_frames >= 1 && stalled_frames <= 1000, "stalled_frames", stalled_frames, "1...1000");
  RefuseUnless(stamp_jitter_ms >= 0 && stamp_jitter_ms <= 1000, "stamp_jitter_ms", stamp_jitter_ms, "0...1000");
}

std::vector<CapturedFrame> CapturedFrames(const RecorderOptions& options, int count, double rate_hz,
                                          std::uint64_t seed) {
  options.Check();
  Random random(Hash(seed) ^ Hash(0x5374616c6c));
  const double stall_chance = std::min(1.0, options.stalls_per_minute / (60 * rate_hz));
  std::vector<CapturedFrame> captured;
  int lost = 0;
  for (int number = 0; number < count; ++number) {
    // As many numbers are drawn for each frame, whatever becomes of it.
    const bool stalls = random.Chance(stall_chance);
    const int length = 1 + random.Below(options.stalled_frames);
    const double stray =
        std::clamp(1e-3 * options.stamp_jitter_ms * random.Gaussian() * rate_hz, -kLargestStray, kLargestStray);
    if (number > 0 && lost == 0 && stalls) lost = length;
    if (lost > 0) {
      --lost;
      continue;
    }
    captured.push_back({number, number == 0 ? 0.0 : (number + stray) / rate_hz});
  }
  return captured;
}

}  // namespace turnscale
