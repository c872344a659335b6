// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "turnscale/rescale/rescale.h"
#include "turnscale/rescale/test_drifting_drive.h"

namespace turnscale {

inline const Eigen::Quaterniond kIdentity = Eigen::Quaterniond::Identity();
inline const LeverArm kCar{1.2, 0.004};
constexpr double kUnit = 17.0;

/// Of the car with this lever arm, everything else as usual.
inline RescaleOptions OptionsFor(const LeverArm& car) {
  RescaleOptions options;
  options.car.lever_arm = car.length;
  options.car.side_slip = car.side_slip;
  return options;
}

/// Of the scale at any pose, against the known one.
inline double WorstLogError(const RescaleResult& result, const ScaledDrive& drive) {
  double worst = 0;
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    worst = std::max(worst, std::abs(std::log(result.poses[i].metres_per_unit / drive.metres_per_unit[i])));
  }
  return worst;
}

/// Poses from which the first step of a turn leads and to which the last does.
struct PosesOfTurn {
  int first = 0;
  int last = 0;
};
inline PosesOfTurn PosesOf(const RescaleResult& result, int turn) {
  const TurnEstimate& estimate = result.estimate->turns[turn];
  return {result.steps[estimate.first_step].first, result.steps[estimate.last_step].last};
}

}  // namespace turnscale
