// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/mapping/calibration_verdict.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"
#include "turnscale/odometry/road_heights.h"
#include "turnscale/scale/turn_estimate.h"

namespace turnscale {

/// The scale of a drive, estimated from all keyframes of the map (EstimateScale). With a contradicted calibration, the
/// steps have errors beyond their noise: single-turn scales are used, and no stabilisation is looked for. With one in
/// doubt, a lag is not adopted, as a principal point that is a little off looks like one.
RefinedScale RefineScale(const Map& map, const MountCalibration& mount, const std::vector<MeasuredHeight>& heights,
                         const OdometryOptions& options, CalibrationVerdict calibration);

/// A turn as results list it. `steps` are those of the estimate, along keyframes or other poses; `frame_of` gives the
/// frame of each.
TurnResult TurnResultOf(const TurnEstimate& turn, const std::vector<VehicleStep>& steps,
                        const std::function<int(int keyframe)>& frame_of);

}  // namespace turnscale
