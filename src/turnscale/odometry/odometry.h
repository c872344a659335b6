// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/mapping/lens_refinement.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/camera_refinement.h"
#include "turnscale/odometry/drive_scale.h"
#include "turnscale/odometry/frame_counter.h"
#include "turnscale/odometry/frame_history.h"
#include "turnscale/odometry/frame_tracker.h"
#include "turnscale/odometry/image_mask.h"
#include "turnscale/odometry/map_initializer.h"
#include "turnscale/odometry/map_start.h"
#include "turnscale/odometry/map_upkeep.h"
#include "turnscale/odometry/metric_path.h"
#include "turnscale/odometry/motion_model.h"
#include "turnscale/odometry/mount_jump.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"
#include "turnscale/odometry/road_observer.h"
#include "turnscale/odometry/tracking_loss.h"
#include "turnscale/odometry/turned_views.h"

namespace turnscale {

/// Estimates the camera's trajectory from the images of a drive: one call per frame, in the order of time.
///
/// The map keeps the arbitrary unit of its initialisation. The scale is estimated beside it (DriveScale); metric poses
/// follow from both. Neither time per frame nor memory grows with the drive, except for the poses of frames and
/// keyframes: observations of keyframes that no adjustment can change are moved to a temporary file (MapArchive).
/// Finish processes the whole drive; where turns are constrained (ConstrainTurns), it has the whole map in memory.
///
/// Lens, calibration (CameraRefinement) and readjusted poses (MapUpkeep) are computed in the background, while the
/// frames after a keyframe are processed, if OpenCV may use more than one thread. Results are applied at a keyframe
/// that is fixed when the work starts. At a gap and in Finish, all pending results are applied at once. Neither depends
/// on the number of threads.
class Odometry {
 public:
  /// Throws InputError when an option is invalid, the camera has a width without a height, a focal length that is
  /// not above 0, or a principal point that is not finite.
  Odometry(const OdometryOptions& options, const CameraModel& camera);

  /// Leaves out the pixels of all images that are 0 in an 8-bit image of their size. Before the first image: later it
  /// throws InternalError. Throws InputError if it is of another type, or leaves out all pixels.
  void SetMask(const cv::Mat& mask);

  /// Processes the next image (8-bit gray), taken at `time` seconds, and returns the online estimate of its pose.
  /// Throws InputError, and changes nothing, when it is empty or its size is not the camera's (or the first image's, if
  /// the camera has none), when the time is not finite or not after that of the previous frame, or when many frames
  /// are so far apart that times cannot be seconds. Throws InternalError after Finish.
  FrameResult Process(const cv::Mat& gray, double time);

  /// The next frame has no usable image: its pose is predicted and flagged. Throws InputError for the time as Process
  /// does.
  FrameResult ProcessUnreadable(double time);

  /// Ends the drive: closes a turn in progress, adjusts all keyframes, and computes the scale of the whole drive. No
  /// frame may follow.
  void Finish();

  /// Every frame so far with its refined pose, metric once the turns so far determine the scale. Frames before
  /// initialisation have the first known pose (none while there is no map at all).
  std::vector<FrameResult> RefinedFrames() const { return RefinedFrames(Refined()); }

  /// The scale of the drive so far. Before Finish it is computed at each call, in time linear in the drive's length.
  RefinedScale Refined() const;

  /// The map's valid landmarks and its keyframes' cameras, in metres if the scale is known.
  MapPoints RefinedMap() const { return RefinedMap(Refined()); }

  /// The same with what Refined has given.
  std::vector<FrameResult> RefinedFrames(const RefinedScale& refined) const;
  MapPoints RefinedMap(const RefinedScale& refined) const;

  /// The options in effect: those given, without those that the lens model does not support.
  const OdometryOptions& options() const { return options_; }
  const Map& map() const { return map_; }
  /// The online path of the keyframes, metric once the scale is known.
  const MetricPath& live_path() const { return scale_.live_path(); }
  /// What was found of the map in the latest tracked image.
  const std::vector<FeatureTrack>& tracks() const { return tracker_.found(); }
  /// The camera by which the map's pixels are undistorted: as given, with the radial correction found so far.
  const CameraModel& camera() const { return map_.camera; }
  /// 0 where pixels are left out of the next image: those given, and those found to stand still while the scene moves
  /// (8 bit, else 255). Empty if none are.
  const cv::Mat& mask() const { return mask_.pixels(); }
  /// The correction of the lens calibration estimated from the drive.
  LensRefinement lens() const { return camera_refinement_.lens(); }
  /// The consistency test of the given calibration.
  CalibrationCheck calibration_check() const { return camera_refinement_.calibration_check(); }
  /// Adjustments of the map after a keyframe, in the background, and of sections at the end that failed, as a position
  /// was no number: there, the map stayed as it was.
  int failed_adjustments() const { return failed_adjustments_; }
  /// At the latest keyframe: of the online estimate, after Finish of the refined one.
  ScaleState scale_state() const;
  /// The images are upside down, by the road that they show: left and right are exchanged in the path.
  bool is_upside_down() const { return road_.IsRoadAbove(); }
  /// The camera-to-vehicle rotation, as given or found.
  const MountCalibration& mount() const { return scale_.mount(); }

 private:
  void CheckImage(const cv::Mat& gray);
  /// There is no map to track against: none yet, or tracking has been lost for so long that another one is needed.
  bool waits_for_map() const { return initializer_.has_value(); }
  void WaitForMap();
  /// Numbers the next frame, which has no pose yet.
  FrameResult NewFrame(double time, TrackingState state);
  FrameResult Initialize(const FlowImage& image, FrameResult result);
  /// Where the map goes on after a gap.
  StartPlace PlaceAfterGap(const InitialMap& start) const;
  void StartMap(const FlowImage& image, const InitialMap& start);
  TrackedFrame Track(FlowImage& image, const RigidTransform& predicted, FrameResult& result);
  /// Takes the motion of a frame that was tracked, before motion_ does: it may show that the camera jumped on the car.
  void ObserveMount(const FrameResult& result, const RigidTransform& camera_from_world);
  /// Passes on a jump of the camera, if there is one.
  void TakeJump(const std::optional<MountJump>& jump);
  FrameResult Bridge(const RigidTransform& predicted, FrameResult result);
  /// The map is not found again: waits for another one, which goes on from the motion so far.
  void GiveUpMap(double time);
  /// Where the drive ends with a frozen view, what the car did is not known.
  void ForgetFrozenEnd();

  /// The latest frame becomes a keyframe.
  void AddKeyframe(const FrameResult& result);
  /// Tracks of the latest keyframe that move with the scene, as far as that can be told: their landmarks.
  std::vector<int> LandmarksOfScene() const;
  /// Measures the height above the road at the latest keyframe, whose image this is. Empty where it does not show.
  std::optional<MeasuredHeight> ObserveRoad(const FlowImage& image);
  /// The frame becomes a keyframe of the map, which is adjusted, and new features of its image landmarks. Returns the
  /// height above the road that it shows.
  std::optional<MeasuredHeight> ExtendMap(const FlowImage& image, FrameResult& result);
  /// Updates the scale with the latest keyframe and the height that was measured there, if any, and gives the result
  /// its psi and theta. Returns whether the keyframe ended a turn.
  bool ObserveScale(const std::optional<MeasuredHeight>& height, FrameResult& result);
  void StartBackgroundWork(bool turn_ended);
  /// Waits for the work that is due at this keyframe, and moves map, tracks and motion model to its results. When it
  /// is due does not depend on how long it takes.
  void ApplyBackgroundWork();
  /// Replaces the radial correction of all pixels of map and tracks.
  void CorrectLens(double radial_correction);
  /// Applies pending work, then readjusts the remaining keyframes at once.
  void Readjust();
  /// Adjusts all keyframes of the archived drive.
  void AdjustWholeDrive();
  /// Scales the archived drive to metres by constraints on the lengths of turns.
  void ConstrainTurnsOfDrive();
  /// Interpolates the path across losses of tracking.
  void BridgeGapsOf(RefinedScale& refined) const;
  /// The map has been readjusted: what else knows its keyframes follows.
  void FollowReadjustment(AppliedReadjustment applied, const RigidTransform& last_from_keyframe);
  /// Lengths at keyframes `first`... have changed by these factors.
  void FollowMap(int first, const std::vector<double>& factors, RigidTransform last_from_keyframe);
  /// The latest frame as seen from the latest keyframe.
  RigidTransform LastFromKeyframe() const;
  /// Stores the frame's pose, and returns it in metres if the scale is known.
  FrameResult MetricResult(const FrameResult& result, const RigidTransform& camera_from_world);
  FrameResult MetricResult(FrameResult result, int keyframe, const RigidTransform& camera_from_world);

  OdometryOptions options_;
  FrameCounter frame_counter_;
  ImageMask mask_;
  std::optional<MapInitializer> initializer_;  ///< while there is no map to track against
  FrameTracker tracker_;
  MotionModel motion_;
  TrackingLoss loss_;
  TurnedViews turned_views_;
  MountJumpDetector mount_jumps_;
  Map map_;
  MapUpkeep upkeep_;
  CameraRefinement camera_refinement_;
  RoadObserver road_;
  DriveScale scale_;
  FrameHistory history_;

  /// Keyframe at which the map started with features that stood still, until a turn shows whether they are far away.
  std::optional<int> start_in_doubt_;
  int failed_adjustments_ = 0;
  bool finished_ = false;
  std::optional<RefinedScale> refined_;  ///< once the drive is over
};

}  // namespace turnscale
