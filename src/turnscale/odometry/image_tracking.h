// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <opencv2/core.hpp>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/map.h"
#include "turnscale/mapping/pose_estimation.h"
#include "turnscale/odometry/feature_tracks.h"
#include "turnscale/odometry/image_step.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// What a pose is estimated from. Tracks that contradict it count as lost: mistracked, or on moving objects.
struct TrackedPose {
  FollowedTracks tracks;
  PoseEstimate estimate;
  /// Only a sample of the landmarks was looked for. The tracks' undistorted pixels are then less the residuals that the
  /// last image had.
  bool is_sampled = false;
};

/// Whether a pose has enough inliers to be taken for the camera's.
bool IsBelievable(const TrackingOptions& options, const PoseEstimate& estimate);

/// The pose of an image that follows soon, from a sample of the landmarks that are compared with their reference views;
/// needs no pyramid of it. Empty where they do not agree. Pixels of `mask` that are 0 are left out (8 bit; empty: none
/// are).
std::optional<TrackedPose> TrackSample(const OdometryOptions& options, const Map& map, const cv::Mat& mask,
                                       const ImageStep& step, const RigidTransform& predicted);

/// Tracks the map's landmarks into the next image and estimates the camera's pose from them, starting at `predicted`.
/// Where that fails, it starts in turn at the motion model's other predictions, at the last pose if the camera has
/// stood (what passes may have hidden nearly all that the last image showed), and at what a wide search finds. Where
/// all fail, the pose returned is not believable. `mask` as above.
TrackedPose TrackImage(const OdometryOptions& options, const Map& map, const cv::Mat& mask, const ImageStep& step,
                       const RigidTransform& predicted);

}  // namespace turnscale
