// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/rescale/scale_evidence.h"
#include "turnscale/rescale/stretch.h"
#include "turnscale/rescale/sway_step.h"

namespace turnscale {

/// Where the estimator begins.
struct ScaleStart {
  double log_scale = 0;
  double sway_sigma = 0;  ///< of a step, odometry units
};

/// From one robust line through all steps, and the scales that the turns show one by one: large turns have more to say,
/// those whose LeverArmRatio is below `min_ratio` nothing. `car` has the mean of what is known beforehand; its
/// log-scale is not read. Nothing where no turn is slow enough and swings the camera outwards.
std::optional<ScaleStart> StartScale(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                     const DriveState& car, double lever_arm, double huber, double min_ratio);

/// The least sideways noise that is believed in, however quiet the odometry (odometry units): the model itself is no
/// better. On motion without any noise (a simulator's truth) the differences of speed within a turn would else outweigh
/// the prior of the side slip.
double LeastSwaySigma(const std::vector<SwayStep>& steps);

}  // namespace turnscale
