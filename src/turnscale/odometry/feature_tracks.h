// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/features/patch_alignment.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// A landmark, with a depth or still without, as the latest image shows it.
struct FeatureTrack {
  int landmark = 0;                                       ///< index into Map::landmarks
  cv::Point2f pixel;                                      ///< in the image as it came
  Eigen::Vector2d undistorted = Eigen::Vector2d::Zero();  ///< in the ideal pinhole image
  /// Where the last keyframe saw it, undistorted; empty where that one did not.
  std::optional<Eigen::Vector2d> in_keyframe;
  /// What the landmark looks like: the image of a keyframe and its pixel there, as the image came. Shared, since tracks
  /// are copied in every frame.
  std::shared_ptr<const cv::Mat> reference_image;
  cv::Point2f reference_pixel;
  int reference_keyframe = 0;  ///< index into Map::keyframes
  int last_keyframe = 0;       ///< the latest one that saw it, index into Map::keyframes
  /// Of a landmark without a depth: its motion in the last image beyond that of infinitely distant points, pixels per
  /// unit of length that the camera moved. Empty where it is not known.
  std::optional<Eigen::Vector2d> parallax = std::nullopt;
  double parallax_base = 0;  ///< how far the camera had moved when the parallax was measured, units of length
};

/// An image and the camera's pose in it; for the time of a call, as it refers to the image.
struct LocatedImage {
  const FlowImage& image;
  const RigidTransform& camera_from_world;
};

/// Where each track is expected in an image: landmarks with a depth are projected, the others turned with the camera.
std::vector<cv::Point2f> PredictPixels(const Map& map, const std::vector<FeatureTrack>& tracks,
                                       const RigidTransform& last_from_world,
                                       const RigidTransform& predicted_from_world);

/// What became of tracks in the next image.
struct FollowedTracks {
  std::vector<FeatureTrack> found;  ///< with their pixels there
  std::vector<FeatureTrack> lost;   ///< as they were
};

/// Finds tracks in the second image. Those without a depth have to track back to where they came from. `levels`: see
/// TrackPoints.
FollowedTracks FollowTracks(const FlowOptions& options, const Map& map, const FlowImage& first, const FlowImage& second,
                            const std::vector<FeatureTrack>& tracks, const std::vector<cv::Point2f>& guesses,
                            std::optional<int> levels = {});

/// The same for tracks without a depth, once the camera's pose is known: where their parallax was measured over a
/// comparable distance, they are searched near the pixel that it predicts first. Notes the parallax of those found.
FollowedTracks FollowWithoutDepth(const FlowOptions& options, const Map& map, const LocatedImage& first,
                                  const LocatedImage& second, const std::vector<FeatureTrack>& tracks);

/// Compares a track whose landmark has a depth with what the landmark looks like in its reference keyframe, at the size
/// and turn that the camera's pose gives it, and corrects its pixel, starting at `guess`: optical flow from image to
/// image drifts, systematically so where everything grows. False where it looks different or is out of sight; the track
/// is then left as it was.
bool AlignTrack(const PatchAlignmentOptions& options, const Map& map, const LocatedImage& current,
                const cv::Point2f& guess, FeatureTrack& track);

/// AlignTrack for many tracks, on as many threads as OpenCV is set to use: one flag a track. A track without a guess is
/// left as it was.
std::vector<uchar> AlignTracks(const PatchAlignmentOptions& options, const Map& map, const LocatedImage& current,
                               const std::vector<std::optional<cv::Point2f>>& guesses,
                               std::vector<FeatureTrack>& tracks);

/// How the neighbourhood of a landmark in its reference keyframe maps into a camera, facing it: pixels as the images
/// came, 2x2. Empty where one of the two cannot see it.
std::optional<Eigen::Matrix2d> CurrentFromReference(const Map& map, const FeatureTrack& track,
                                                    const RigidTransform& camera_from_world);

/// The same for a point (in the world) and any other view as the reference.
std::optional<Eigen::Matrix2d> CurrentFromReference(const CameraModel& camera, const Eigen::Vector3d& point,
                                                    const RigidTransform& reference_from_world,
                                                    const RigidTransform& camera_from_world);

/// Where a camera shows a landmark, as the image comes; empty where it is out of sight.
std::optional<cv::Point2f> PixelOf(const Map& map, int landmark, const RigidTransform& camera_from_world);

/// At most `most` of the tracks whose landmarks have a depth, evenly out of all of these.
std::vector<const FeatureTrack*> SampleWithDepth(const Map& map, const std::vector<FeatureTrack>& tracks, size_t most);

/// The pixels of tracks, as the image shows them.
std::vector<cv::Point2f> PixelsOf(const std::vector<FeatureTrack>& tracks);

}  // namespace turnscale
