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

}  // namespace turnscale
