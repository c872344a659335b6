// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/keypoint_matching.h"
#include "turnscale/odometry/turned_views.h"

namespace turnscale {

struct Mount;

/// When the rotation between the images before and after a gap counts as measured (docs/gaps.md).
struct GapRotationOptions {
  KeypointOptions keypoints;
  /// Largest distance of a match to its epipolar line, pixels.
  double max_epipolar_error = 1.0;
  /// A match that has moved by no more than this across the gap is left out unless the car stood, pixels: the
  /// dashboard, reflections and burnt-in text stand still in the image however the car has turned, and would outvote
  /// the scene. Far points straight ahead stand still too: those are kept of which an earlier view shows that they move
  /// in the image as the camera turns. Above the reach of a rotation, which is twice the distance above: what is left
  /// does not agree with standing still.
  double max_still_motion = 3.0;
  /// Least number of matches that agree with the motion.
  int min_matches = 20;
  /// Their least share of all matches.
  double min_match_share = 0.2;
  /// The same for a rotation alone, as of a car that has stood: it may also explain what stands still in the image.
  double min_still_share = 0.6;
  /// Largest share of the matches that agree which may lie on one plane, such as a wall: then the motion is ambiguous.
  double max_plane_share = 0.8;
  /// Largest rotation about other axes than the car's vertical, degrees, beyond what the uncertain rotation of the
  /// camera on the car explains.
  double max_tilt_deg = 5.0;
  /// A car moves in a direction between those that it faces before and after, or in the opposite one. Largest deviation
  /// from that, degrees, likewise.
  double max_direction_error_deg = 10.0;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Images on both sides of a gap in the tracking, 8-bit gray.
struct GapImages {
  cv::Mat before;            ///< the last one that was tracked
  cv::Mat lost = {};         ///< the first one that was not; may be empty
  cv::Mat after;             ///< the first view of the map after the gap
  EarlierView earlier = {};  ///< than `before`, if there is one from another direction
  bool car_stood = false;    ///< before the gap and after it
};

/// Rotation of the camera across a gap.
struct GapRotation {
  Eigen::Quaterniond after_from_before = Eigen::Quaterniond::Identity();
  double sigma = 0;  ///< standard deviation of the angle, rad
};

/// Measures the rotation by keypoints that the images before and after the gap share, or else by way of the lost one.
/// Empty where they do not have enough of the scene in common: what stands still in the image is none of it, unless the
/// car stood or an earlier view tells. `mask`: as ImageMask::pixels.
std::optional<GapRotation> MeasureGapRotation(const GapRotationOptions& options, const CameraModel& camera,
                                              const GapImages& images, const cv::Mat& mask, const Mount& mount);

}  // namespace turnscale
