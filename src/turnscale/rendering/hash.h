// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace turnscale {

/// Mixes the bits of a number so that neighbours have nothing in common (the finaliser of splitmix64, Steele et al.
/// 2014): random numbers by their place rather than by their turn.
constexpr std::uint64_t Hash(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15U;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBU;
  return x ^ (x >> 31U);
}

/// Uniform in [0, 1), from a number (and a second and third one).
constexpr float HashUniform(std::uint64_t a, std::uint64_t b = 0, std::uint64_t c = 0) {
  return static_cast<float>(Hash(a ^ Hash(b ^ Hash(c))) >> 40U) * 0x1p-24F;
}

/// Uniform numbers one after the other.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) : seed_(Hash(seed)) {}

  /// In [0, 1).
  float Next() { return HashUniform(seed_, count_++); }
  /// In [low, high).
  float Next(float low, float high) { return low + (high - low) * Next(); }
  /// In [0, count).
  int NextIndex(int count) { return static_cast<int>(Next() * static_cast<float>(count)); }

 private:
  std::uint64_t seed_;
  std::uint64_t count_ = 0;
};

}  // namespace turnscale
