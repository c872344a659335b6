// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/mapping/map.h"

namespace turnscale {

struct LandmarkOptions {
  /// Angle under which two keyframes have to see a landmark before it is given a depth, degrees.
  double min_parallax_deg = 0.5;
  /// The same in pixels at the image's centre, where that is more. With a short focal length, clouds would get a depth
  /// from rotations that are wrong by one or two pixels.
  double min_parallax = 2;
  /// Largest reprojection error of a landmark in any keyframe, pixels.
  double max_reprojection_error = 2.0;
  /// Least distance of a new landmark, as a share of that of the nearest tenth with a depth: what passes before a car
  /// that stands would seem to be very near, by the noise of its pose.
  double min_distance_share = 0.02;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Gives a depth to those of the landmarks that have none yet and are seen by now under enough parallax. The latest
/// keyframe sees all of them, also those that have one.
void TriangulateLandmarks(const LandmarkOptions& options, const std::vector<int>& landmarks, Map& map);

/// Reprojection error of a point in an image, pixels; infinite where it lies behind the camera.
double ReprojectionError(const Pinhole& pinhole, const RigidTransform& camera_from_world, const Eigen::Vector3d& point,
                         const Eigen::Vector2d& pixel);

/// The same of a landmark in a keyframe.
double ReprojectionError(const Map& map, int landmark, const LandmarkObservation& seen);

/// Removes observations that contradict the landmark's position, and landmarks that too few keyframes are left to see.
/// Returns the landmarks that lost their observation in `latest_keyframe` or were removed, so that their tracks end.
std::vector<int> CullLandmarks(const LandmarkOptions& options, const std::vector<int>& landmarks, int latest_keyframe,
                               Map& map);

}  // namespace turnscale
