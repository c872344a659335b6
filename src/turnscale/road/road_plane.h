// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "turnscale/geometry/angle.h"
#include "turnscale/road/road_patches.h"

namespace turnscale {

struct RoadPlaneOptions {
  RoadPatchOptions patches;
  double pitch_sigma = 0.25 / kDegreesPerRadian;  ///< of the road against the direction of travel, rad
  double roll_sigma = 3.0 / kDegreesPerRadian;    ///< of the road against the vehicle's axes, rad
  double vertical_curvature_sigma = 0.003;        ///< curvature of the road along the way, rad per height
  double unevenness = 0.01;                       ///< of the road about its plane, heights
  double max_deviation = 4;                       ///< of pitch and roll, in their sigmas; else rejected
  double min_correlation = 0.7;                   ///< of a patch with the earlier image
  int min_patches = 20;                           ///< inliers
  double min_share = 0.5;                         ///< of inliers in the patches that match
  double max_sigma = 0.1;                         ///< relative, of a height

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The plane of the road below the camera: the tangent plane of a road that curves up or down ahead.
struct RoadPlane {
  double height = 0;                                  ///< of the current camera above it, in the unit of the motion
  double sigma = 0;                                   ///< relative
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< downwards, in the current camera's axes
  int patches = 0;                                    ///< inliers
  double share = 0;                                   ///< of inliers in the patches that match
  /// Derivatives of ln(height / length of the motion) by a small rotation (rad) that follows `earlier_from_current`,
  /// and by a change of the motion's unit vector of translation, in the axes of the earlier camera. With the motion
  /// turns the direction of travel, from which the plane's pitch is expected.
  Eigen::RowVector3d by_rotation = Eigen::RowVector3d::Zero();
  Eigen::RowVector3d by_direction = Eigen::RowVector3d::Zero();
};

/// The plane that makes the road region of one image look like that in an earlier one: photometric, patch by patch
/// (inverse compositional, gain and offset free), and a robust fit of one surface to all patches. Patches that do not
/// move like this surface (cars, kerbs, reflections, shadows that move along) are outliers.
///
/// `height`: where the search starts, within about 15 %. Empty where too few patches agree, or on a height more than
/// 25 % away.
std::optional<RoadPlane> FitRoadPlane(const RoadPlaneOptions& options, const RoadPair& pair, const RoadRegion& region,
                                      double height);

/// The same without a start: the heights between two bounds are tried.
std::optional<RoadPlane> FindRoadPlane(const RoadPlaneOptions& options, const RoadPair& pair, const RoadRegion& region,
                                       double least_height, double greatest_height);

}  // namespace turnscale
