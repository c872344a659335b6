// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/kinematics/speed_smoother.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// Speed of the rear axle along the car's axis at each frame from the first measured pose on, m/s, negative in reverse.
/// `frames` are metric poses of the whole drive (Odometry::RefinedFrames), `lever_arm` in metres. The sigma includes
/// that of the scale. Empty if the scale is pending or fewer than three poses are measured.
std::vector<SpeedReading> SpeedsOf(const std::vector<FrameResult>& frames, double lever_arm);

}  // namespace turnscale
