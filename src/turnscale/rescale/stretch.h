// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/rescale/sway_step.h"

namespace turnscale {

/// Neighbouring steps that are taken to share one scale: a turn, or a piece of what lies between two turns.
struct Stretch {
  int first = 0;  ///< steps first..last
  int last = 0;
  bool turning = false;
  bool after_gap = false;  ///< its first step is the one across a gap
  double angle = 0;        ///< sum of psi, rad, positive to the right
  double length = 0;       ///< odometry units
  double middle = 0;       ///< length of the drive up to the middle of the stretch, odometry units
};

inline std::span<const SwayStep> StepsOf(const std::vector<SwayStep>& steps, const Stretch& stretch) {
  return std::span(steps).subspan(stretch.first, stretch.last - stretch.first + 1);
}

struct StretchOptions {
  /// Weaker than those of `turnscale run`: what a poor turn is worth, its variance says. A step of the usual 3 deg
  /// counts as turning from 1 deg on, three of them make a turn.
  TurnDetectorOptions turns{.min_step_angle = 1.0 / 57.295779513082320877, .min_steps = 3};
  /// Longest straight stretch, steps: some hundred metres, over which the scale drifts little and the direction of
  /// travel (the crown of the road, a side wind) may well differ from the next one's.
  int max_straight_steps = 40;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Parts the steps, without gap or overlap, in their order.
std::vector<Stretch> SplitIntoStretches(const std::vector<SwayStep>& steps, const StretchOptions& options);

}  // namespace turnscale
