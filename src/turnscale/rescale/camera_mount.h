// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/trajectory.h"

namespace turnscale {

/// The camera-to-vehicle rotation, as a path shows it.
struct MountFromPath {
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();  ///< the paper's Q
  bool observed =
      false;  ///< by turns; else the camera is taken as upright and looking along the mean direction of travel
};

/// The paper's Q from the path itself, whichever way its body's axes lie. `timed` says that the poses' times are
/// seconds, `gaps` which poses do not hang together with the one before (increasing).
///
/// Throws InputError where the path has no direction of travel, or is too short to tell.
MountFromPath FindCameraMount(const Trajectory& trajectory, bool timed, const std::vector<int>& gaps = {});

}  // namespace turnscale
