// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"
#include "turnscale/rescale/pose_scale.h"

namespace turnscale {

/// What all turns of a drive together say.
struct DriveScale {
  std::vector<PoseScale> keyframes;  ///< metres per unit of the start
  CarRefinement car;
};

/// What all turns of the keyframes' path together say, each with its variance (RescaleTrajectory). Empty where they say
/// nothing.
///
/// Lengths of the map at keyframe k are `unit_at_keyframe[k]` times those in the unit of the start.
std::optional<DriveScale> DriveScaleOf(const Map& map, const std::vector<double>& unit_at_keyframe,
                                       const MountCalibration& mount, const OdometryOptions& options);

}  // namespace turnscale
