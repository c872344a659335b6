// SPDX-License-Identifier: MIT
#include "turnscale/simulation/captured_frames.h"

#include <algorithm>

#include "turnscale/base/random.h"
#include "turnscale/io/range_check.h"

namespace turnscale {
namespace {

// A stamp strays by this part of an interval at most, so that stamps stay in order.
constexpr double kLargestStray = 0.25;

}  // namespace

void RecorderOptions::Check() const {
  CheckRange("recorder.megabits_per_second", megabits_per_second, 0.01, 1000);
  CheckRange("recorder.stalls_per_minute", stalls_per_minute, 0, 600);
  CheckRange("recorder.stalled_frames", stalled_frames, 1, 1000);
  CheckRange("recorder.stamp_jitter_ms", stamp_jitter_ms, 0, 1000);
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
