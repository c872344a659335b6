// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// A stretch of the way, driven without stopping.
struct RouteLeg {
  std::vector<Eigen::Vector2d> points;  ///< (x, z) of the rear axle, metres, in the order of driving; at least two
  double speed = 5;                     ///< m/s, at most
  bool reverse = false;                 ///< driven backwards
  double wait = 0;                      ///< seconds that the car stands at its end
  /// Speeds at the points instead of `speed`, from a recording (m/s): empty or one per point. Where they are lower than
  /// 0.2 m/s on the way, the car creeps on. A drive whose first leg has speeds starts at the first of them, one whose
  /// last leg has them and no wait ends at the last; all other legs start and end at standstill.
  std::vector<double> speeds;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Metres along the straight lines between points.
double PathLength(const std::vector<Eigen::Vector2d>& points);

/// Leaves out what comes after `metres` of a way, but for its first 5 metres. Legs have no speeds of their own.
void CutLegs(double metres, std::vector<RouteLeg>& legs);

/// A path of straight pieces with rounded corners, points about `step` metres apart. Corners are arcs of the radius
/// with transitions on either side over which the curvature grows evenly, so that nobody has to turn the wheel at once.
/// Where the pieces are too short (neighbouring corners share a piece by halves) first the transitions and then the
/// radius become smaller. Throws InputError for less than two corners, corners that coincide, a path that turns back at
/// a corner (by more than 170 degrees), or a radius or step that is not positive.
std::vector<Eigen::Vector2d> RoundCorners(const std::vector<Eigen::Vector2d>& corners, double radius, double step);

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
