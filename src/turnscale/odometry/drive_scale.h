// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/mapping/calibration_verdict.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/live_path.h"
#include "turnscale/odometry/metric_path.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/mount_jump.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/readjustment.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"
#include "turnscale/odometry/road_heights.h"
#include "turnscale/scale/live_scale.h"
#include "turnscale/scale/scale_state.h"

namespace turnscale {

/// Estimates the scale beside the map, which it never changes: keyframes in, metric trajectory out.
///
/// Online: a filter over the steps so far, including the current turn. Refined: the smoother over the whole drive
/// (EstimateScale). Both pass over a keyframe whose pose is not finite, which stays where the one before it is.
class DriveScale {
 public:
  /// `aspect_sigma`: of the pixels, relative (CameraModel).
  explicit DriveScale(const OdometryOptions& options, double aspect_sigma = 0);

  /// Takes the height measured at the latest keyframe, before Add.
  void AddHeight(const MeasuredHeight& height) {
    // A camera that has been moved may have another height.
    if (mount_.moves() == 0) heights_.push_back(height);
  }

  /// The camera jumped on the car. `keyframe`: the first one after it; their number if it is still to come.
  /// Re-evaluates the drive.
  void AddJump(const Map& map, int keyframe, const MountJump& jump);

  /// Drops all heights, as the images are upside down. Call Reread afterwards: the filter has used them.
  void ForgetHeights() { heights_.clear(); }

  /// Takes the new keyframes of the map. Returns whether they ended a turn: then the keyframes since the previous turn
  /// should be adjusted again, followed by Reread, now or some keyframes later.
  bool Add(const Map& map);

  /// Takes over what `mount` has learned from readjusted keyframes, and re-evaluates their steps.
  void Reread(const Map& map, MountCalibration mount, const ReadjustedKeyframes& keyframes);
  /// All keyframes have been adjusted: learns from those that are new, and re-evaluates the whole drive.
  void Reread(const Map& map);

  ScaleState state() const { return live_path_.state(); }
  double sigma() const { return live_path_.sigma(); }  ///< relative, at the latest keyframe; infinite while pending
  const MountCalibration& mount() const { return mount_; }
  /// The online estimate.
  const MetricPath& live_path() const { return live_path_.path(); }
  /// Keyframe up to which the keyframes were adjusted when the last used turn ended; 0 before the first.
  int last_turn_end() const { return live_path_.last_turn_end(); }

  /// The smoother over all keyframes of the map (RefineScale).
  RefinedScale Refine(const Map& map, CalibrationVerdict calibration = CalibrationVerdict::kNotContradicted) const;

 private:
  /// Returns how the keyframe ended a turn.
  TurnEnd Feed(const Map& map, int keyframe);
  void UpdateLive(const Map& map, LivePath::Change change);

  /// The live filter as it was before a keyframe, from where on it takes the keyframes again.
  struct Checkpoint {
    int keyframe = 0;
    StepBuilder builder;
    LiveScale live;
    Eigen::Quaterniond vehicle_from_camera;
  };
  /// Goes back to the checkpoint, or to the start without one. Returns the next keyframe.
  int Restart();

  OdometryOptions options_;
  double aspect_sigma_ = 0;
  MountCalibration mount_;
  std::vector<MeasuredHeight> heights_;  ///< above the road
  StepBuilder builder_;
  LiveScale live_;  ///< with a lever arm of 1 if no length is given, to detect turns
  std::optional<Checkpoint> checkpoint_;
  LivePath live_path_;
  int keyframes_ = 0;                  ///< taken so far
  bool used_turn_ended_ = false;       ///< with the latest keyframe
  std::vector<int> unread_turn_ends_;  ///< keyframes that ended used turns which have not been re-evaluated
};

}  // namespace turnscale
