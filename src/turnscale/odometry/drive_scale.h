// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "turnscale/kinematics/turning_motion.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/odometry/metric_path.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"
#include "turnscale/scale/live_scale.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// What the whole drive says of its scale.
struct RefinedScale {
  MetricPath path;
  std::vector<double> sigmas;      ///< relative, one a keyframe; infinite while the scale is pending
  std::vector<char> turning;       ///< the step that leads to the keyframe belongs to a turn
  std::vector<char> in_used_turn;  ///< from the keyframe that the turn's first step leaves
  std::vector<TurnResult> turns;
  std::optional<ScaleEstimate> estimate;  ///< empty while the scale is pending
  std::string reason;                     ///< why
  /// Intrinsics that the images of turns contradict; sigmas include what such a calibration may cost.
  std::vector<ParameterEstimate> contradicted_calibration;
};

/// Relative standard deviation of what a calibration that is off as the estimates say may cost the scale: the error of
/// the direction of travel over the lever arm's share of it. A coarse bound (benchmarks/variants): metres from such a
/// calibration are not to be relied on. 0 without contradictions.
double CalibrationSigma(const std::vector<ParameterEstimate>& contradictions, double focal_length);

/// Widens all sigmas of `refined` by that.
void WidenForCalibration(const std::vector<ParameterEstimate>& contradictions, double focal_length,
                         RefinedScale& refined);

/// Observes the scale beside the map, which it never changes: keyframes in, metric path out.
///
/// Live: a filter over the steps so far, the turn under way included. Refined: the smoother over the whole drive
/// (EstimateScale).
class DriveScale {
 public:
  explicit DriveScale(const OdometryOptions& options);

  /// Takes the keyframes of the map that are new to it. Returns whether they ended a turn: the keyframes since the turn
  /// before are worth adjusting once more then, and Reread is due.
  bool Add(const Map& map);

  /// Keyframes `first`... have been adjusted: learns the camera's rotation from them, and reads their steps again.
  /// Keyframes before `settled` will not be adjusted again while the drive goes on.
  void Reread(const Map& map, int first, int settled);
  /// All keyframes have been adjusted: the same from the start.
  void Reread(const Map& map);

  ScaleState state() const { return state_; }
  double sigma() const { return sigma_; }  ///< relative, at the latest keyframe; infinite while pending
  const MountCalibration& mount() const { return mount_; }
  /// As known at this moment.
  const MetricPath& live_path() const { return live_path_; }
  /// Keyframe up to which the keyframes were adjusted when the last turn ended; 0 before the first turn.
  int last_turn_end() const { return last_turn_end_; }

  /// The smoother over all keyframes of the map; `follow_turns`: see ScaleEstimatorOptions.
  RefinedScale Refine(const Map& map, bool follow_turns = false) const;

 private:
  /// Returns whether the keyframe ended a turn.
  bool Feed(const Map& map, int keyframe);
  /// Live positions from keyframe `first` on, and from where the scale has changed.
  void UpdateLive(const Map& map, int first);
  /// Brings the live scale within a turn to `scale`. Returns the keyframe from which on it has changed.
  int SpreadScale(const Map& map, double scale);

  /// The live filter before a keyframe, where reading starts again.
  struct SettledPart {
    int keyframes = 0;
    StepBuilder builder;
    LiveScale live;
    Eigen::Quaterniond vehicle_from_camera;
  };

  OdometryOptions options_;
  MountCalibration mount_;
  StepBuilder builder_;
  LiveScale live_;  ///< with a lever arm of 1 where none is given: turns are found all the same
  std::optional<SettledPart> settled_;
  MetricPath live_path_;
  ScaleState state_ = ScaleState::kPending;
  double sigma_ = std::numeric_limits<double>::infinity();
  int keyframes_ = 0;  ///< taken so far
  int last_turn_end_ = 0;
  bool turn_ended_ = false;  ///< with the latest keyframe
};

/// What the camera did on the step from keyframe `step` to the next.
TurningMotion StepMotion(const Map& map, int step, const MountCalibration& mount);

}  // namespace turnscale
