// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// A landmark, with a depth or still without, as the latest image shows it.
struct FeatureTrack {
  int landmark = 0;                                       ///< index into Map::landmarks
  cv::Point2f pixel;                                      ///< in the image as it came
  Eigen::Vector2d undistorted = Eigen::Vector2d::Zero();  ///< in the ideal pinhole image
  /// Where the last keyframe saw it, undistorted.
  Eigen::Vector2d in_keyframe = Eigen::Vector2d::Zero();
};

/// Where each track is expected in a camera: landmarks with a depth are projected, the others turned with the camera.
std::vector<cv::Point2f> PredictPixels(const Map& map, const CameraModel& camera,
                                       const std::vector<FeatureTrack>& tracks, const RigidTransform& last_from_world,
                                       const RigidTransform& predicted_from_world);

/// The tracks that are found again in the second image, with their pixels there.
std::vector<FeatureTrack> FollowTracks(const FlowOptions& options, const CameraModel& camera, const FlowImage& first,
                                       const FlowImage& second, const std::vector<FeatureTrack>& tracks,
                                       const std::vector<cv::Point2f>& guesses);

/// The pixels of tracks, as the image shows them.
std::vector<cv::Point2f> PixelsOf(const std::vector<FeatureTrack>& tracks);

}  // namespace turnscale
