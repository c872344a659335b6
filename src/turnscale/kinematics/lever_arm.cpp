// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/lever_arm.h"

#include <cmath>
#include <string>

#include "turnscale/base/error.h"

namespace turnscale {

void LeverArm::Check() const {
  if (!std::isfinite(length) || length <= 0) {
    throw InputError("lever arm: " + std::to_string(length) + " m; it must be a positive number of metres");
  }
  if (!std::isfinite(side_slip) || side_slip < 0) {
    throw InputError("side slip: " + std::to_string(side_slip) + " s^2/m; it must be 0 or a positive number");
  }
}

}  // namespace turnscale
