// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/calibration/camera_step.h"
#include "turnscale/geometry/trajectory.h"

namespace turnscale {

/// How the axes of a trajectory's body lie.
enum class AxisConvention {
  kCamera,   ///< x right, y down, z forward, or as far from that as a camera may be turned
  kVehicle,  ///< x forward, y left, z up: a vehicle's or robot's body
};

/// Tells the two apart: a camera does not turn about its viewing axis when the car turns, a vehicle's body turns about
/// its z axis and goes along its x axis. While nothing turns, a body that goes along its x axis is a vehicle's.
AxisConvention FindAxisConvention(const std::vector<CameraStep>& steps);

/// The path of a camera on the vehicle that looks along its x axis and is level.
Trajectory InCameraAxes(Trajectory vehicle_path);

}  // namespace turnscale
