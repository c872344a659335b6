// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace turnscale {

/// Mixes the bits of a number so that neighbours have nothing in common (splitmix64, Steele, Lea and Flood 2014):
/// random bits by their place rather than by their turn.
constexpr std::uint64_t Hash(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// In [0, 1), of the highest bits.
constexpr double ToUniform(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1.0p-53; }

/// In [0, 1), by a place of up to three numbers; as a float.
constexpr float HashUniform(std::uint64_t a, std::uint64_t b = 0, std::uint64_t c = 0) {
  return static_cast<float>(Hash(a ^ Hash(b ^ Hash(c))) >> 40) * 0x1.0p-24F;
}

/// Random numbers that are the same with every compiler and library, which those of <random> are not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(Hash(seed)) {}

  /// In [0, 1).
  double Uniform() { return ToUniform(Next()); }
  /// In [low, high).
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  float UniformFloat(float low, float high) {
    return low + (high - low) * static_cast<float>(Next() >> 40) * 0x1.0p-24F;
  }
  /// In 0...count - 1.
  int Below(int count) { return static_cast<int>(Uniform() * count); }
  bool Chance(double probability) { return Uniform() < probability; }
  /// Mean 0, standard deviation 1 (Box and Muller 1958).
  double Gaussian() {
    const double radius = std::sqrt(-2 * std::log(1 - Uniform()));
    return radius * std::cos(2 * std::numbers::pi * Uniform());
  }

 private:
  std::uint64_t Next() { return state_ = Hash(state_); }

  std::uint64_t state_;
};

}  // namespace turnscale
