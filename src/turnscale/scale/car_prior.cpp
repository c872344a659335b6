// SPDX-License-Identifier: MIT
#include "turnscale/scale/car_prior.h"

#include <cmath>

#include "turnscale/base/error.h"

namespace turnscale {

void CarPrior::Check() const {
  const auto require = [](bool good, const char* what) {
    if (!good) throw InputError(what);
  };
  require(std::isfinite(lever_arm) && lever_arm > 0, "car.lever_arm: has to be a positive number of metres");
  require(lever_arm_sigma >= 0 && lever_arm_sigma < lever_arm,
          "car.lever_arm_sigma: has to be from 0 to below the lever arm, metres");
  require(side_slip >= 0 && side_slip < 1, "car.side_slip: has to be from 0 to below 1 s^2/m");
  require(side_slip_sigma >= 0 && side_slip_sigma < 1, "car.side_slip_sigma: has to be from 0 to below 1 s^2/m");
  require(yaw_sigma > 0 && yaw_sigma < 1, "car.yaw_sigma: has to be above 0 and below 1 rad");
}

}  // namespace turnscale
