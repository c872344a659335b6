// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/mapping/lens_refinement.h"
#include "turnscale/mapping/map.h"
#include "turnscale/mapping/map_archive.h"
#include "turnscale/mapping/pose_estimation.h"
#include "turnscale/odometry/drive_scale.h"
#include "turnscale/odometry/feature_tracks.h"
#include "turnscale/odometry/frame_history.h"
#include "turnscale/odometry/map_initializer.h"
#include "turnscale/odometry/motion_model.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// What a new map's unit of length is in the old one.
struct UnitGuess {
  double unit = 1;
  double sigma = 1;  ///< relative standard deviation; 1 where nothing is known
};

/// From a drive's images to the camera's path: one call a frame, in the order of time.
///
/// The map keeps the arbitrary unit of its start. The scale is observed beside it (DriveScale), and metric poses follow
/// from both. Work per frame and memory do not grow with the drive, but for the poses of keyframes and frames: what
/// settled keyframes saw is moved to a temporary file (MapArchive). Finish goes over the whole drive.
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

  /// The drive is over: a turn that is still going on counts, the whole drive is adjusted, and its scale is settled. No
  /// frame may follow.
  void Finish();

  /// Every frame so far with its refined pose, metric as far as all turns up to now tell. Frames before the map started
  /// have the first pose known (and none only while there is no map at all).
  std::vector<FrameResult> RefinedFrames() const;

  /// What the drive so far says of its scale.
  RefinedScale Refined() const;

  /// The map's valid landmarks and its keyframes' cameras, in metres as far as the scale is known.
  MapPoints RefinedMap() const;

  /// Grows whenever the refined poses of the whole drive change: a map starts, a turn ends. Between, each keyframe
  /// moves only the latest few a little.
  int revision() const { return revision_; }

  /// The options in effect: those given, without what the camera's lens does not allow.
  const OdometryOptions& options() const { return options_; }
  const Map& map() const { return map_; }
  /// What the drive has told of the lens beyond its calibration.
  const LensRefinement& lens() const { return lens_; }
  /// What the drive says of the calibration that was given.
  const CalibrationCheck& calibration_check() const { return calibration_check_; }
  ScaleState scale_state() const;
  /// How the camera is turned on the car, as given or found.
  const MountCalibration& mount() const { return scale_.mount(); }

 private:
  void CheckImage(const cv::Mat& gray);
  FrameResult NewFrame(double time, TrackingState state);
  FrameResult Initialize(const FlowImage& image, FrameResult result);
  void StartMap(const InitialMap& start);
  UnitGuess UnitAfterGap(const InitialMap& start) const;
  void LocateWaitingFrames(const InitialMap& start, int first_landmark, int keyframe);
  bool Repeats(const FlowImage& image, const RigidTransform& predicted, double time) const;
  bool Repeats(const WaitingFrame& before, const WaitingFrame& waiting, int first_landmark) const;
  /// The camera's pose by tracking from the predicted pose, or where that fails from others; empty where all fail.
  std::optional<RigidTransform> Track(const FlowImage& image, const RigidTransform& predicted, FrameResult& result);
  std::pair<FollowedTracks, PoseEstimate> TrackFrom(const FlowImage& image, const RigidTransform& predicted) const;
  PoseEstimate EstimateFramePose(const RigidTransform& predicted, FollowedTracks& tracks) const;
  void AlignWithMap(const FlowImage& image, const RigidTransform& camera_from_world, FollowedTracks& tracks) const;
  bool Believable(const PoseEstimate& estimate) const;
  FrameResult Bridge(const RigidTransform& predicted, FrameResult result);
  bool NeedsKeyframe(const RigidTransform& camera_from_world, int inliers) const;
  void AddKeyframe(const RigidTransform& camera_from_world, FrameResult& result);
  void RefineLens();
  /// Takes the latest keyframe; settles the latest ones where it ended a turn, or where they have become many.
  void ObserveScale(FrameResult& result);
  /// Adjusts the latest keyframes that have not been settled yet, or were under another lens, and reads their scale
  /// again.
  void Settle();
  /// Moves what keyframes before `last` saw to the archive.
  void Archive(int last);
  /// Adjusts all keyframes of the archived drive.
  void AdjustWholeDrive();
  /// Brings the archived drive to metres by constraints on the lengths of turns.
  void HoldTurnsOfDrive();
  /// Lengths at keyframes `first`... have grown by these factors.
  void FollowMap(int first, const std::vector<double>& factors, RigidTransform last_from_keyframe);
  /// The latest frame as seen from the latest keyframe.
  RigidTransform LastFromKeyframe() const;
  void ReplenishTracks(const FlowImage& image);
  void RenewReferences(const FlowImage& image);
  void DetectNewFeatures(const FlowImage& image);
  /// Keeps the frame's pose, and gives it in metres as far as they are known.
  FrameResult MetricResult(const FrameResult& result, const RigidTransform& camera_from_world);
  FrameResult MetricResult(FrameResult result, int keyframe, const RigidTransform& camera_from_world);

  OdometryOptions options_;
  CameraModel camera_;
  MapInitializer initializer_;
  MotionModel motion_;
  LensRefinement lens_;
  CalibrationCheck calibration_check_;
  DriveScale scale_;
  FrameHistory history_;
  Map map_;
  MapArchive archive_;
  std::vector<double> lens_of_keyframe_;  ///< correction under which each keyframe was settled; NaN before
  std::optional<RefinedScale> refined_;   ///< once the drive is over
  double calibration_sigma_ = 0;          ///< what a contradicted calibration adds to the live sigma

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
