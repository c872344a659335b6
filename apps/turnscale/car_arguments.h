// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/kinematics/lever_arm.h"

namespace turnscale {

/// What --side-slip says, s^2/m. Throws InputError where no car slips like that.
inline double CheckedSideSlip(double side_slip) {
  if (side_slip >= 0 && side_slip < 1) return side_slip;
  throw InputError(fmt::format("--side-slip {}: give c in s^2/m, from 0 (rigid car) to below 1; cars have about {}",
                               side_slip, kUsualSideSlip));
}

/// What --lever-arm says, metres. Throws InputError where no car has its camera there.
inline double CheckedLeverArm(double lever_arm) {
  constexpr double kLongest = 20;  // more is a slip of the unit
  if (lever_arm > 0 && lever_arm <= kLongest) return lever_arm;
  throw InputError(
      fmt::format("--lever-arm {}: give the metres from the rear axle forward to the camera, above 0 and up to {}",
                  lever_arm, kLongest));
}

/// What --lever-arm-sigma says, metres.
inline double CheckedLeverArmSigma(double sigma) {
  if (sigma >= 0 && sigma <= 1) return sigma;
  throw InputError(fmt::format("--lever-arm-sigma {}: give metres, from 0 (known exactly) to 1", sigma));
}

/// What --side-slip-sigma says, s^2/m.
inline double CheckedSideSlipSigma(double sigma) {
  if (sigma >= 0 && sigma < 1) return sigma;
  throw InputError(fmt::format("--side-slip-sigma {}: give s^2/m, from 0 (known exactly) to below 1", sigma));
}

}  // namespace turnscale
