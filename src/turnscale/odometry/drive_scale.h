// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/rescale/pose_scale.h"

namespace turnscale {

/// What all turns of the keyframes' path together say of the scale, each with its variance (RescaleTrajectory): one per
/// keyframe, metres per unit of the start. Empty where they say nothing.
///
/// Lengths of the map at keyframe k are `unit_at_keyframe[k]` times those in the unit of the start.
std::vector<PoseScale> ScaleKeyframes(const Map& map, const std::vector<double>& unit_at_keyframe,
                                      const MountCalibration& mount, const OdometryOptions& options);

}  // namespace turnscale
