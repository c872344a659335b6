// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/simulation/reference_path.h"
#include "turnscale/simulation/vehicle.h"

namespace turnscale {

/// Speeds with which to start and end (m/s).
struct EndSpeeds {
  double start = 0;
  double end = 0;
};

/// Speeds (m/s, not negative) every `interval` seconds that bring a car from the path's start to its end: the path's
/// own, lower in curves and where the wheels could not be turned as fast, within the limits of acceleration, and
/// without jerks. An end whose speed the path does not allow is driven at what it allows.
std::vector<double> PlanSpeeds(const CarOptions& options, const ReferencePath& path, const EndSpeeds& ends,
                               double interval);

}  // namespace turnscale
