// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// Default slip-angle coefficient c of an unknown car, s^2/m: about 2.5 deg of rear slip angle per g.
constexpr double kUsualSideSlip = 0.0045;
/// Its standard deviation over cars with soft to stiff tyres, s^2/m.
constexpr double kUsualSideSlipSigma = 0.002;
/// Relative standard deviation of a measured c: load and tyre pressure change.
constexpr double kGivenSideSlipSigma = 0.12;
/// Standard deviation of a lever arm measured with a tape, metres.
constexpr double kTapeSigma = 0.03;

/// Distance of the camera ahead of the point without lateral velocity.
struct LeverArm {
  double length = 0;     ///< L: from the rear axle forward to the camera, metres
  double side_slip = 0;  ///< c: the rear axle's slip angle per lateral acceleration, s^2/m; 0 is the paper's rigid car

  /// The effective lever arm at a speed (m/s): L - c v^2. The rear tyres slip outwards in a turn, and the point
  /// without lateral velocity moves forward. Negative beyond v = sqrt(L/c).
  double At(double speed) const { return length - side_slip * speed * speed; }

  /// Throws InputError when the length is not positive or the slip is negative.
  void Check() const;
};

}  // namespace turnscale
