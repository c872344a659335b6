// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>

#include "turnscale/mapping/map.h"
#include "turnscale/odometry/metric_path.h"
#include "turnscale/odometry/results.h"
#include "turnscale/scale/live_scale.h"

namespace turnscale {

/// The online path of the keyframes in metres: the scale that was known at each, and what a turn reveals of those
/// before it.
class LivePath {
 public:
  /// The latest `movable` keyframes may still be moved by local bundle adjustment.
  explicit LivePath(int movable) : movable_(movable) {}

  /// What has changed since the last update.
  struct Change {
    int first = 0;                            ///< keyframe from which on the map has new positions
    bool turn_ended = false;                  ///< a used turn ended with the latest keyframe
    std::optional<int> reread_turn_end = {};  ///< a used turn has been re-evaluated that ended at this keyframe
  };
  /// Takes the live scale at the latest keyframe of the map; empty while it is pending.
  void Update(const Map& map, const std::optional<LiveReading>& now, const Change& change);

  const MetricPath& path() const { return path_; }
  ScaleState state() const { return state_; }
  double sigma() const { return sigma_; }  ///< relative, at the latest keyframe; infinite while pending
  /// Keyframe up to which the keyframes were adjusted when the last used turn ended; 0 before the first.
  int last_turn_end() const { return last_turn_end_; }

 private:
  /// Brings the scale within a turn to `scale` at keyframe `last` and beyond. Returns the keyframe from which on it has
  /// changed.
  int SpreadScale(const Map& map, double scale, int last);

  int movable_;
  MetricPath path_;
  ScaleState state_ = ScaleState::kPending;
  double sigma_ = std::numeric_limits<double>::infinity();
  int last_turn_end_ = 0;
};

}  // namespace turnscale
