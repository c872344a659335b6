// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/features/optical_flow.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/feature_tracks.h"
#include "turnscale/odometry/image_mask.h"
#include "turnscale/odometry/motion_model.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/repeated_image.h"

namespace turnscale {

struct TrackedFrame {
  int tracked = 0;  ///< features found in the image
  int inliers = 0;  ///< of those with a depth
  /// Only a sample of the landmarks was looked for; the tracks stay those of the last image in which all were.
  bool is_sampled = false;
  /// Empty where tracking failed; the tracks are then those of the image before.
  std::optional<RigidTransform> camera_from_world = std::nullopt;
};

/// Tracks the map's landmarks from image to image and estimates the camera's pose from them. The map is the
/// caller's; only Replenish adds to it.
class FrameTracker {
 public:
  explicit FrameTracker(const OdometryOptions& options) : options_(options) {}

  /// Begins anew with what an image shows; `landmarks` of it have a depth.
  void Start(const FlowImage& image, std::vector<FeatureTrack> tracks, int landmarks);

  /// Whether the image is the last tracked one once more.
  bool IsRepeat(const Map& map, const FlowImage& image, const RigidTransform& predicted,
                const ImageTiming& timing) const;

  /// Whether all pixels of the image are those of the last tracked one: the noise of a camera makes any two differ.
  bool ShowsSamePixels(const FlowImage& image) const;

  /// The camera's pose in the next image, taken at `time` seconds: searched from the predicted pose, then from the
  /// motion model's others. Builds the image's pyramid unless a sample of the landmarks is enough. `mask`: as
  /// ImageMask::pixels.
  TrackedFrame Track(const Map& map, const cv::Mat& mask, FlowImage& image, const MotionModel& motion,
                     const RigidTransform& predicted, double time);

  /// Whether the camera had stood still for a second at least in the last image in which all landmarks were tracked.
  bool HasStood() const { return has_stood_; }

  /// Whether the image that was tracked last has to become a keyframe. One in which only a sample of the landmarks was
  /// tracked never does.
  bool NeedsKeyframe(const Map& map, const TrackedFrame& frame) const;

  /// The image that was tracked last is the map's latest keyframe: renews reference images, and adds new features as
  /// landmarks without a depth, out of the image's candidates (FindCandidates). `mask`: as ImageMask::pixels.
  void Replenish(const FlowImage& image, const cv::Mat& mask, const std::vector<cv::KeyPoint>& candidates, Map& map);

  /// Ends tracks without a depth that have not moved in the image since they were first seen, although the scene moves
  /// there. Returns how the tracks have moved. For a new keyframe at this pose, before it is in the map.
  std::vector<ObservedMotion> DropStatic(const Map& map, const RigidTransform& camera_from_world);

  /// What the last image shows in which all landmarks were tracked.
  const std::vector<FeatureTrack>& tracks() const { return tracks_; }

  /// What was found in the latest image: there, possibly a sample.
  const std::vector<FeatureTrack>& found() const { return sampled_ ? sampled_->tracks : tracks_; }

  /// The latest image that was tracked, 8-bit gray.
  const cv::Mat& latest_gray() const { return sampled_ ? sampled_->gray : last_image_.gray; }

  /// Ends the tracks of landmarks.
  void Drop(const std::vector<int>& landmarks);

  /// Landmarks have moved to other indices; -1: they are gone.
  void Reindex(const std::vector<int>& new_index);

  /// The unit of the map's latest keyframes has changed: a length there is `factor` times what it was.
  void Rescale(double factor);

  /// Undistorted pixels have changed.
  void Correct(const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& corrected);

 private:
  // An image since the last one in which all landmarks were tracked. Poses of the map do not change before the next
  // one.
  struct SampledImage {
    cv::Mat gray;
    std::vector<FeatureTrack> tracks;  // the sample that it shows
    RigidTransform last_from_world;    // the camera's pose in `last_image_`
  };

  // Whose landmarks are those of the map.
  std::vector<std::vector<FeatureTrack>*> AllTracks();
  // Whether images are missing, or were not tracked, for much longer than usual before this time.
  bool FollowsGap(double time) const;
  // Ends the tracks that optical flow alone has followed: across a gap, only the epipolar line of each confirms them,
  // and too many depths would be wrong.
  void DropWithoutDepth(const Map& map);
  // Updates `stands_since_` and `has_stood_` with the image tracked last.
  void NoticeStanding(const Map& map, int inliers, double time);
  // The image is that of the latest keyframe.
  void RenewReferences(const Map& map, const std::shared_ptr<const cv::Mat>& image);
  void DetectNewFeatures(const std::shared_ptr<const cv::Mat>& image, const cv::Mat& mask,
                         const std::vector<cv::KeyPoint>& candidates, Map& map);

  OdometryOptions options_;
  FlowImage last_image_;                   ///< the latest one in which all landmarks were tracked
  std::vector<FeatureTrack> tracks_;       ///< what it shows
  std::vector<FeatureTrack> lost_tracks_;  ///< recently seen landmarks that are not in it
  std::optional<double> last_image_time_;  ///< of that image, seconds; empty where it began the tracks
  std::optional<double> last_interval_;    ///< of images without a gap, seconds; empty if unknown
  std::optional<SampledImage> sampled_;    ///< the latest image, if only a sample was tracked
  std::optional<double> stands_since_;     ///< seconds; empty: the camera moves
  bool has_stood_ = false;                 ///< for a second at least, up to that image
  int landmarks_in_keyframe_ = 0;          ///< with a depth, when the last keyframe was made
  int features_in_keyframe_ = 0;           ///< with or without a depth
};

}  // namespace turnscale
