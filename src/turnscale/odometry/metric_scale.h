// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "turnscale/kinematics/pooled_scale.h"
#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/kinematics/turning_motion.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"
#include "turnscale/odometry/scale_uncertainty.h"
#include "turnscale/scale/map_scaling.h"

namespace turnscale {

/// What a new keyframe told of the scale.
struct ScaleUpdate {
  TurningMotion motion;  ///< of the step that led to the keyframe; zero where that step bridges a gap
  /// The map was adjusted or brought to metres. Lengths at keyframe k are `factors[k]` times what they were; empty
  /// where nothing changed.
  std::vector<double> factors;
};

/// Watches the keyframes for turns, and brings the map to metres whenever one closes (section IV).
class MetricScale {
 public:
  explicit MetricScale(const OdometryOptions& options);

  /// Takes a keyframe of the map; each once, in their order.
  ScaleUpdate AddKeyframe(int keyframe, Map& map);

  /// The path ends, here or where tracking was lost: a turn that is still open closes.
  ScaleUpdate EndPath(Map& map);

  /// The drive is over: its path ends, and its turns count with what all of them say.
  ScaleUpdate Finish(Map& map);

  ScaleState state() const { return state_; }
  /// How the camera is turned on the car, as far as the drive has told.
  const MountCalibration& mount() const { return mount_; }
  /// What all turns together say of the car; empty where they said nothing, or are not asked (ScaleOptions::smooth).
  const std::optional<CarRefinement>& car() const { return car_; }
  double sigma() const;  ///< relative standard deviation at the latest keyframe

  std::vector<TurnResult> Turns(const Map& map) const;

  /// Writes into refined frames what is known after the turns: the camera's rotation on the car, psi and theta of
  /// keyframes, turning, and the state and sigma of the scale, which between two turns come from both.
  /// `keyframe_of_frame` names each frame's keyframe, -1 where it has none.
  void Annotate(const Map& map, const std::vector<int>& keyframe_of_frame, std::vector<FrameResult>& frames) const;

 private:
  struct Turn {
    TurningRegion region;
    TurnResult result;                 ///< without what depends on the refined map
    std::vector<double> step_lengths;  ///< metres, of a used turn: the recovery after it holds them
    double relative_sigma = std::numeric_limits<double>::infinity();
  };

  /// Adjusts all keyframes since the last turn at once: the windows of the live odometry knew less of them, and of the
  /// lens. Gives what lengths at each keyframe are times what they were.
  std::vector<double> AdjustSinceLastTurn(Map& map) const;
  std::vector<double> Close(const TurningRegion& region, Map& map);
  /// Reads the turns from this one on, all of them where the mount is known better than before, and recovers the map by
  /// those that tell the scale. What lengths change by goes into `factors`.
  void ReadTurns(int from, Map& map, std::vector<double>& factors);
  /// What the turn tells of the scale; empty where it is not used, with the reason in its result.
  std::optional<TurnScale> Read(const Map& map, Turn& turn) const;
  /// Puts what all turns so far say of the scale of these in the place of what they say themselves.
  void WeighSmoothly(const Map& map, const std::vector<int>& turns, std::span<TurnScale> held);
  void CarryFrom(const TurningRegion& region, const Map& map);
  static TurnScale AsRecovered(const Turn& turn);
  const Turn* LastUsedBefore(int turn) const;

  OdometryOptions options_;
  TurnDetector detector_;
  MountCalibration mount_;
  std::vector<Turn> turns_;
  std::vector<double> total_factors_;    ///< metres at a keyframe per unit of the start
  std::vector<double> smoothed_sigmas_;  ///< relative, of the keyframes that were there at the latest smoothing
  std::optional<CarRefinement> car_;     ///< of that smoothing
  ScaleState state_ = ScaleState::kPending;
  ScaleCarriage since_turn_;
};

}  // namespace turnscale
