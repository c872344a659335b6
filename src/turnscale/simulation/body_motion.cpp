// SPDX-License-Identifier: MIT
#include "turnscale/simulation/body_motion.h"

#include <cmath>
#include <cstdint>

namespace turnscale {
namespace {

constexpr double kDamping = 0.4;
// A thousandth of a pixel to a camera of 1000 pixels.
constexpr double kRestAngle = 1e-6;
constexpr double kRestRate = 1e-5;

constexpr int kWaves = 24;
constexpr double kShortestWave = 2;
constexpr double kLongestWave = 25;

/// The next number of the splitmix64 sequence (Steele, Lea, Flood 2014), in [0, 1).
double NextUniform(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t bits = state;
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebULL;
  bits ^= bits >> 31;
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

}  // namespace

void Suspension::Step(double target, double frequency, double dt) {
  const double omega = 2 * M_PI * frequency;
  rate += dt * (omega * omega * (target - angle) - 2 * kDamping * omega * rate);
  angle += dt * rate;
  if (target == 0 && std::abs(angle) < kRestAngle && std::abs(rate) < kRestRate) *this = {};
}

RoadNoise::RoadNoise(unsigned long long seed) {
  std::uint64_t state = seed;
  for (int i = 0; i < kWaves; ++i) {
    const double length = kShortestWave * std::pow(kLongestWave / kShortestWave, (i + NextUniform(state)) / kWaves);
    waves_.push_back({2 * M_PI / length, 2 * M_PI * NextUniform(state)});
  }
}

double RoadNoise::At(double distance) const {
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::cos(wave.frequency * distance + wave.phase);
  return sum * std::sqrt(2.0 / kWaves);
}

double RoadNoiseGain(double speed) { return 2 * std::abs(speed) / (std::abs(speed) + 10); }

}  // namespace turnscale
