// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "turnscale/geometry/rotation.h"
#include "turnscale/scale/scale_filter.h"

namespace turnscale {

/// Scale and heading of a path drift as random walks, whose standard deviations over 100 m are these. The scale's is
/// that of the estimator's settings, the heading's is above what the recorded drives show.
constexpr double kScaleDriftPer100m = DriftOptions().per_100m;
constexpr double kHeadingDriftPer100m = 0.25 / kDegreesPerRadian;

/// The antenna of a GPS is not where the camera is, metres.
constexpr double kAntennaError = 0.5;

/// Standard deviation (metres, in each direction) of where a path is, `way` metres along it from a place that is
/// right, if scale and heading are right there. `sigma` is the relative one of the scale that is not common to the
/// whole path.
inline double OwnPathError(double way, double sigma) {
  const double drift = std::hypot(kScaleDriftPer100m, kHeadingDriftPer100m) * std::sqrt(way / 100);
  // The mean of a random walk has a third of the variance of its end.
  return std::hypot(way * std::hypot(drift / std::sqrt(3), sigma), kAntennaError);
}

}  // namespace turnscale
