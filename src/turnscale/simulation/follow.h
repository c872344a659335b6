// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/trajectory.h"

namespace turnscale {

/// The way of a recorded drive.
struct RecordedPath {
  std::vector<Eigen::Vector3d> points;  ///< (x, up, z), metres, at least 0.3 m apart as seen from above
  std::vector<double> speeds;           ///< m/s, one per point: the least between this point and the next
};

/// The rear axle's way from the poses of a camera (metres), in the frame of the car at the first pose: it starts near
/// the origin, and that pose is taken to be level.
///
/// Positions are smoothed over time (0.3 s) and speeds read off there, heights over 4 m of the way besides; where the
/// car stands, one point is kept.
/// Throws InputError when times do not grow or the car moves less than a metre in all.
RecordedPath RearAxlePath(const Trajectory& trajectory, const RigidTransform& vehicle_from_camera);

}  // namespace turnscale
