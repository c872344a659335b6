// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/mapping/lens_refinement.h"
#include "turnscale/mapping/map.h"
#include "turnscale/mapping/pose_estimation.h"
#include "turnscale/odometry/feature_tracks.h"
#include "turnscale/odometry/frame_history.h"
#include "turnscale/odometry/map_initializer.h"
#include "turnscale/odometry/metric_scale.h"
#include "turnscale/odometry/motion_model.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// From a drive's images to the camera's path: one call a frame, in the order of time.
class Odometry {
 public:
  /// Throws InputError when an option makes no sense, or the camera has a width without a height.
  Odometry(const OdometryOptions& options, const CameraModel& camera);

  /// Takes the next image (8-bit gray) taken at `time` seconds, and gives what is known of the camera's pose at this
  /// moment. Throws InputError when its size is not the camera's, or where that is unknown, not the first image's, and
  /// when the time is not after the frame before.
  FrameResult Process(const cv::Mat& gray, double time);

  /// The next frame has no usable image: its pose is predicted and flagged.
  FrameResult ProcessUnreadable(double time);

  /// The drive is over: a turn that is still going on is used.
  void Finish();

  /// Every frame so far with its refined pose: what the absolute scale recovery has gone back over. Frames before the
  /// map started have the first pose known (and none only while there is no map at all).
  std::vector<FrameResult> RefinedFrames() const;

  /// Grows whenever the refined poses of the whole drive change: a map starts, a turn closes. Between, each keyframe
  /// moves only the latest few a little.
  int revision() const { return revision_; }

  std::vector<TurnResult> Turns() const;
  /// The options in effect: those given, without what the camera's lens does not allow.
  const OdometryOptions& options() const { return options_; }
  const Map& map() const { return map_; }
  /// What the drive has told of the lens beyond its calibration.
  const LensRefinement& lens() const { return lens_; }
  ScaleState scale_state() const { return scale_.state(); }
  /// How the camera is turned on the car, as given or found.
  const MountCalibration& mount() const { return scale_.mount(); }
  /// What all turns together say of the car (MetricScale::car).
  const std::optional<CarRefinement>& car() const { return scale_.car(); }

 private:
  void EndPath();
  void CheckImage(const cv::Mat& gray);
  FrameResult NewFrame(double time, TrackingState state);
  FrameResult Initialize(const FlowImage& image, FrameResult result);
  void StartMap(const InitialMap& start);
  double UnitAfterGap(const InitialMap& start) const;
  void LocateWaitingFrames(const InitialMap& start, int first_landmark, int keyframe);
  PoseEstimate LocateFrame(const RigidTransform& predicted, FollowedTracks& tracks) const;
  void AlignWithMap(const FlowImage& image, const RigidTransform& camera_from_world, FollowedTracks& tracks) const;
  bool Believable(const PoseEstimate& estimate) const;
  FrameResult Bridge(const RigidTransform& predicted, FrameResult result);
  bool NeedsKeyframe(const RigidTransform& camera_from_world, int inliers) const;
  void AddKeyframe(const FlowImage& image, const RigidTransform& camera_from_world, FrameResult& result);
  void RefineLens();
  void ObserveScale(FrameResult& result);
  /// The latest frame as seen from the latest keyframe.
  RigidTransform LastFromKeyframe() const;
  void ApplyScale(const ScaleUpdate& update, RigidTransform last_from_keyframe);
  void RenewReferences(const FlowImage& image);
  void DetectNewFeatures(const FlowImage& image);
  FrameResult Record(const FrameResult& result, const RigidTransform& camera_from_world);
  FrameResult Record(FrameResult result, int keyframe, const RigidTransform& camera_from_world);

  OdometryOptions options_;
  CameraModel camera_;
  MapInitializer initializer_;
  MotionModel motion_;
  LensRefinement lens_;
  MetricScale scale_;
  FrameHistory history_;
  Map map_;

  FlowImage last_image_;                   ///< the latest one whose pose was measured
  std::vector<FeatureTrack> tracks_;       ///< what it shows
  std::vector<FeatureTrack> lost_tracks_;  ///< landmarks seen lately that it does not show
  int landmarks_in_keyframe_ = 0;          ///< with a depth, when the last keyframe was made
  bool mapping_ = false;                   ///< there is a map to track against
  int lost_frames_ = 0;                    ///< in a row, up to now
  double last_time_ = -std::numeric_limits<double>::infinity();
  int frames_ = 0;
  int revision_ = 0;
};

}  // namespace turnscale
