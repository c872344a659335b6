// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Rotates from the world of a trajectory, however it lies, to axes x right, y ahead, z up: up is what the car has
/// above it on the mean over the drive, ahead is the car's horizontal direction at the first pose.
/// `vehicle_from_camera` is the rotation from the trajectory's body to the car's axes (x right, y down, z forward). The
/// trajectory may not be empty.
Eigen::Quaterniond LevelFromWorld(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera);

/// Right and up on a page that shows the drive from above, in the world's axes: the world's x axis goes to the right,
/// or its z axis where x points up. The trajectory may not be empty.
Eigen::Matrix<double, 2, 3> TopViewAxes(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera);

}  // namespace turnscale
