// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Usual standard deviation of a tracked pixel, pixels.
constexpr double kTrackedPixelSigma = 0.5;

/// What a keyframe saw of a landmark.
struct KeyframeObservation {
  int landmark = 0;                                 ///< index into Map::landmarks
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted, pixels
};

/// An image frame that the map keeps (II-C): its pose and the landmarks seen in it.
struct Keyframe {
  int frame = 0;    ///< number of the image in the drive
  double time = 0;  ///< seconds
  RigidTransform camera_from_world;
  std::vector<KeyframeObservation> observations;
  /// Tracking was lost before this keyframe: its motion from the previous keyframe is bridged, not measured.
  bool after_gap = false;
  /// Relative standard deviation by which the unit of length may have changed across that gap; 0 where there was none.
  double gap_sigma = 0;
  /// Standard deviation of the angle by which the camera has turned across that gap, rad; 0 where there was none.
  double gap_turn_sigma = 0;
  /// Whether that angle was measured in the images on both sides of the gap.
  bool gap_turn_is_measured = false;
  /// Ratio: contrast of the first image that was lost in that gap over that of the last one before it; 1 where there
  /// was no gap.
  double contrast_left = 1;
  /// Variance of the logarithm of the unit of length from the previous keyframe to this one for independent pixel
  /// errors (UnitVariance), infinite if no landmark connects them; 0 while it is not known, as near the end of the map.
  double pixel_unit_variance = 0;
};

/// One pixel of a landmark's history.
struct LandmarkObservation {
  int keyframe = 0;                                 ///< index into Map::keyframes
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted, pixels
};

/// A point of the world with its pixel history over keyframes (II-C).
struct Landmark {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in W
  bool valid = false;  ///< triangulated and not culled; invalid landmarks keep their number but take no part
  std::vector<LandmarkObservation> observations;
  int archived_as = -1;  ///< number in the MapArchive, once a keyframe that saw it is there
};

/// Keyframes and landmarks. An observation stands both in its keyframe and in its landmark (see AddObservation,
/// RemoveObservation). Indices of keyframes are stable over the drive; landmarks are numbered anew when old ones leave
/// (MapArchive::Retire).
struct Map {
  /// By which all pixels are undistorted, its radial correction included. Landmarks project with its pinhole.
  CameraModel camera;
  std::vector<Keyframe> keyframes;
  std::vector<Landmark> landmarks;
};

/// Where a keyframe's camera is, in W.
inline Eigen::Vector3d Centre(const Keyframe& keyframe) { return keyframe.camera_from_world.inverse().translation; }

/// Number of keyframes; one more than the index of the last.
inline int CountKeyframes(const Map& map) { return static_cast<int>(map.keyframes.size()); }

/// By how much the camera turned from one keyframe to another, radians.
double TurnBetween(const Map& map, int from, int to);

/// Valid landmarks that any of the keyframes `first`...`last` saw, in ascending order.
std::vector<int> LandmarksSeen(const Map& map, int first, int last);

/// Records that a keyframe saw a landmark, on both sides.
void AddObservation(Map& map, int keyframe, int landmark, const Eigen::Vector2d& pixel);

/// Forgets that a keyframe saw a landmark, on both sides.
void RemoveObservation(Map& map, int keyframe, int landmark);

/// Sets the pixels of landmarks' observations to those of the keyframes. A landmark's have to be in the order of their
/// keyframes.
void CopyPixelsToLandmarks(Map& map);

/// Changes the radial correction of the camera, and with it the pixels of all observations. A landmark's have to be in
/// the order of their keyframes.
void CorrectLens(Map& map, double radial_correction);

/// Takes a landmark out of the map: invalid and without observations. Its number is not used again.
void RemoveLandmark(Map& map, int landmark);

}  // namespace turnscale
