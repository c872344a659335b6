// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "turnscale/geometry/angle.h"
#include "turnscale/road/road_patches.h"

namespace turnscale {

/// Sigmas of a height below are medians on KITTI 07; with the defaults, 1.7 %.
struct RoadPlaneOptions {
  RoadPatchOptions patches;
  /// Of the road against the direction of travel, rad. Six heights ahead, a pitch of this much is 2.6 % of the height.
  /// With a larger one heights are less certain, as the patches alone have to tell the pitch from the height (2.6 %
  /// with 1 degree); with a smaller one, errors of the direction of travel become errors of the height.
  double pitch_sigma = 0.25 / kDegreesPerRadian;
  /// Of the road against the vehicle's axes, rad: bank and crown of the road, roll of the body, and an error of the
  /// camera's rotation. It hardly matters, as patches lie on both sides and show the roll themselves (1.7 % with 10
  /// degrees, too).
  double roll_sigma = 3.0 / kDegreesPerRadian;
  /// Curvature of the road along the way, rad per height: below a camera at 1.65 m, a radius of 550 m. A flat surface
  /// fitted to such a crest or dip is more than 2 % off in height. A smaller one makes heights on flat roads more
  /// certain (1.3 % with 0.0005), a larger one hardly less, as patches show the curvature, too.
  double vertical_curvature_sigma = 0.003;
  /// Of the road about its plane, heights: 16 mm below a camera at 1.6 m. A larger one gives near patches, whose pixels
  /// show the height best, less weight (2.3 % with 0.03, 1.4 % with 0.002); a smaller one lets few of them decide.
  double unevenness = 0.01;
  /// Of pitch and roll, in their sigmas: 1 and 12 degrees; else rejected. A larger one accepts surfaces that are no
  /// lane.
  double max_deviation = 4;
  /// Of a patch with the earlier image, of whose variance it then explains half. With a smaller one, patches that match
  /// by chance take part; with a larger one, heights are lost (five of six on KITTI 07 with 0.9).
  double min_correlation = 0.7;
  /// Inliers, of at most 126 patches. Fewer agree by chance more often; with more, smooth roads show no height.
  int min_patches = 20;
  /// Of inliers in the patches that match: with fewer than half, another surface may have more.
  double min_share = 0.5;
  /// Relative, of a height. Weights are those of sigma, so that a larger one lets in heights that hardly count.
  double max_sigma = 0.1;

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
