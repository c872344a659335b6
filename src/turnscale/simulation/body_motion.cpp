// SPDX-License-Identifier: MIT
#include "turnscale/simulation/body_motion.h"

#include <cmath>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

constexpr double kDamping = 0.4;
// A thousandth of a pixel to a camera of 1000 pixels.
constexpr double kRestAngle = 1e-6;
constexpr double kRestRate = 1e-5;

constexpr int kWaves = 24;
constexpr double kShortestWave = 2;
constexpr double kLongestWave = 25;

}  // namespace

void Suspension::Step(double target, double frequency, double dt) {
  const double omega = 2 * M_PI * frequency;
  rate += dt * (omega * omega * (target - angle) - 2 * kDamping * omega * rate);
  angle += dt * rate;
  if (target == 0 && std::abs(angle) < kRestAngle && std::abs(rate) < kRestRate) *this = {};
}

RoadNoise::RoadNoise(unsigned long long seed) {
  Random random(seed);
  for (int i = 0; i < kWaves; ++i) {
    const double length = kShortestWave * std::pow(kLongestWave / kShortestWave, (i + random.Uniform()) / kWaves);
    waves_.push_back({2 * M_PI / length, 2 * M_PI * random.Uniform()});
  }
}

double RoadNoise::At(double distance) const {
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::cos(wave.frequency * distance + wave.phase);
  return sum * std::sqrt(2.0 / kWaves);
}

double RoadNoiseGain(double speed) { return 2 * std::abs(speed) / (std::abs(speed) + 10); }

}  // namespace turnscale
