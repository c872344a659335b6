// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/kinematics/turning_motion.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// What a new keyframe changed in the scale.
struct ScaleUpdate {
  TurningMotion motion;  ///< of the step that led to the keyframe
  /// The map was brought to metres. Lengths at keyframe k are `factors[k]` times what they were; empty where nothing
  /// changed.
  std::vector<double> factors;
};

/// Watches the keyframes for turns, and brings the map to metres whenever one closes (section IV).
class MetricScale {
 public:
  explicit MetricScale(const OdometryOptions& options);

  /// Takes the keyframe that the map has just been given.
  ScaleUpdate AddKeyframe(Map& map);

  /// The drive is over: a turn that is still open closes.
  ScaleUpdate Finish(Map& map);

  ScaleState state() const { return state_; }
  double sigma() const { return sigma_; }  ///< relative, at the latest keyframe
  std::vector<TurnResult> Turns(const Map& map) const;

  /// Writes what the turns say of the refined frames: psi, theta, turning, state and sigma of the scale.
  void Annotate(const Map& map, std::vector<FrameResult>& frames) const;

 private:
  std::vector<double> Close(const TurningRegion& region, Map& map);

  OdometryOptions options_;
  TurnDetector detector_;
  std::vector<TurningRegion> regions_;
  std::vector<TurnResult> turns_;
  std::vector<double> total_factor_;  ///< metres at a keyframe per unit of the start
  ScaleState state_ = ScaleState::kPending;
  double sigma_ = std::numeric_limits<double>::infinity();
};

}  // namespace turnscale
