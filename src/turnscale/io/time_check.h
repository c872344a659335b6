// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/results.h"

namespace turnscale {

/// Signs that the times of the images are wrong, since no car moves so: a warning each. Wrong times make speeds wrong,
/// and with them the slip of the tyres and the scale.
///
/// * Images that are missing although the times say nothing of it: the car moves at least 1.6 times as fast from one
///   image to the next as before and after, in at least 1 % of the steps and three times.
/// * Times that pass too slowly: more than 8 m/s^2 sideways in the median of the turns that were used.
///
/// `frames`: poses in metres; nothing is said of a trajectory that is up to scale.
std::vector<std::string> TimeWarnings(const std::vector<FrameResult>& frames, const std::vector<TurnResult>& turns);

}  // namespace turnscale
