// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/mapping/map.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// Keyframes first...last, whose scale a turn has observed with this relative standard deviation.
struct ObservedStretch {
  int first = 0;
  int last = 0;
  double sigma = 0;
};

/// What the scale was carried over since it was observed.
struct ScaleCarriage {
  double distance = 0;  ///< metres
  int gaps = 0;         ///< losses of tracking
};

/// Relative variance of the scale after it was carried: a random walk of its logarithm with distance and gaps.
double CarriedVariance(const ScaleOptions& options, double sigma, const ScaleCarriage& carriage);

/// Relative standard deviation of the scale at every keyframe, from the nearest observed stretch before and after it;
/// infinite where nothing was observed. The stretches are in the order of time.
std::vector<double> ScaleSigmas(const ScaleOptions& options, const Map& map,
                                const std::vector<ObservedStretch>& observed);

}  // namespace turnscale
