// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace turnscale {

/// An angle of the body on its springs: a damped oscillator.
struct Suspension {
  double angle = 0;  ///< rad
  double rate = 0;   ///< rad/s

  /// Goes on by `dt` seconds towards `target` (rad), with a natural frequency in Hz. Movements that nobody could see
  /// end at a target of zero: at rest the angle is zero exactly.
  void Step(double target, double frequency, double dt);
};

/// Unevenness of a road: a smooth random function of the distance with mean 0 and standard deviation 1. It has waves
/// of 2 to 25 m, up to 5 Hz at 10 m/s.
class RoadNoise {
 public:
  explicit RoadNoise(unsigned long long seed);
  double At(double distance) const;

 private:
  struct Wave {
    double frequency = 0;  // rad/m
    double phase = 0;
  };
  std::vector<Wave> waves_;
};

/// How much of the unevenness is felt at a speed (m/s, of either sign): 1 at 10 m/s, nothing at standstill.
double RoadNoiseGain(double speed);

}  // namespace turnscale
