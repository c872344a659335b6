// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// Takes the single-turn scales, with the car's constants as given (TurnEstimate::as_given), in place of the joint
/// estimate: the scale passes through them, in proportion to the way between two turns. Turns whose sigma exceeds the
/// smallest one's by `max_sigma_ratio` are not used. Sigma covers their differences from the estimate and from each
/// other. Between two losses of tracking without a turn, the estimate stays.
///
/// Returns false, and changes no scale, if no turn has a scale.
bool UseSingleTurns(double max_sigma_ratio, ScaleEstimate& estimate);

}  // namespace turnscale
