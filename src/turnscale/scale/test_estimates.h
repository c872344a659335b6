// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "turnscale/scale/scale_estimator.h"
#include "turnscale/scale/synthetic_steps.h"

namespace turnscale {

/// A prior of this car, with the usual standard deviations.
inline CarPrior PriorOf(const LeverArm& car) {
  CarPrior prior;
  prior.lever_arm = car.length;
  prior.side_slip = car.side_slip;
  return prior;
}

/// Differences from the model as large as they are taken to be.
inline DriveErrors AsStated(const ScaleEstimatorOptions& options) {
  return {.direction = options.evidence.line.sigma_theta,
          .lever_arm = options.evidence.turn_sigma,
          .slip = options.evidence.slip_sigma,
          .turn_direction = options.evidence.turn_direction_sigma,
          .straight_direction = options.evidence.straight_direction_sigma,
          .per_100m = options.drift.per_100m,
          .per_90deg = options.drift.per_90deg};
}

/// Length of the path.
inline double Metres(const ScaleEstimate& estimate) {
  double metres = 0;
  for (std::size_t i = 0; i < estimate.segments.size(); ++i)
    metres += estimate.segments[i].length * estimate.smoothed[i].metres_per_unit();
  return metres;
}

}  // namespace turnscale
