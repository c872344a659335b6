// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/rescale/scale_estimator.h"
#include "turnscale/rescale/stretch.h"
#include "turnscale/rescale/sway_step.h"

namespace turnscale {

/// The unit of length at one pose.
struct PoseScale {
  double metres_per_unit = 0;  ///< from the whole drive (smoothed)
  double sigma = 0;            ///< relative
  double own_sigma = 0;        ///< relative, without what all turns have in common
  /// From the stretches that had ended by then, but with the noise and the weights of the whole drive; 0 up to the
  /// first turn.
  double filtered_metres_per_unit = 0;
  double filtered_sigma = 0;
};

/// The scale at each of `poses` poses: between the middles of two stretches in proportion to the way, but not across a
/// gap. `common_sigma` (relative) is what all turns have in common.
std::vector<PoseScale> ScalePoses(int poses, const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                  const ScaleEstimate& estimate, double common_sigma);

}  // namespace turnscale
