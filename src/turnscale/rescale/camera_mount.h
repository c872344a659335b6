// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/trajectory.h"

namespace turnscale {

/// The paper's Q from the path itself, whichever way its body's axes lie. Where no turn shows the camera's roll, the
/// camera is taken as upright. `timed` says that the poses' times are seconds, `gaps` which poses do not hang together
/// with the one before (increasing).
///
/// Throws InputError where the path has no direction of travel, or is too short to tell.
Eigen::Quaterniond FindCameraMount(const Trajectory& trajectory, bool timed, const std::vector<int>& gaps = {});

}  // namespace turnscale
