// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/mapping/map.h"
#include "turnscale/mapping/map_archive.h"
#include "turnscale/odometry/frame_history.h"
#include "turnscale/odometry/metric_path.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// All frames of a drive with their refined poses, scale, psi and theta.
std::vector<FrameResult> RefinedFramesOf(const FrameHistory& history, const Map& map, const MountCalibration& mount,
                                         const RefinedScale& refined);

/// The valid landmarks of a drive, those in the archive included, and its cameras, along a metric path.
MapPoints RefinedPointsOf(const MapArchive& archive, const Map& map, const MetricPath& path);

}  // namespace turnscale
