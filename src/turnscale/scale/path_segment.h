// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/kinematics/vehicle_step.h"

namespace turnscale {

/// Consecutive steps that share one scale: a turn, or a part of the straight between two turns.
struct PathSegment {
  int first = 0;  ///< steps first..last
  int last = 0;
  bool turning = false;
  bool road_part = false;  ///< of a straight that is divided into shorter parts since it shows the road (kRoadParts)
  /// Relative, by which the unit may have changed at the start of the segment, across a gap or along a step over which
  /// the landmarks hardly determine it (IsUnitBroken); 0 elsewhere.
  double gap_sigma = 0;
  /// Sum of the steps' unit_variance, but for one that is part of gap_sigma.
  double unit_variance = 0;
  double angle = 0;   ///< sum of psi, rad, positive to the right
  double turned = 0;  ///< sum of |psi|, rad
  double length = 0;  ///< odometry units, without jumps
  double middle = 0;  ///< length of the path up to the middle of the segment, odometry units
};

struct PathSegmentOptions {
  TurnDetectorOptions turns;
  /// Longest straight segment, steps: some hundred metres. The direction of travel differs between segments with crown
  /// and side wind.
  int max_straight_steps = 40;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Whether the landmarks determine the unit of length along the step so badly (sigma above 5 %) that it may be another
/// one afterwards, as after a gap.
bool IsUnitBroken(const VehicleStep& step);

/// The turns among the steps (Algorithm 1), in their order.
std::vector<TurningRegion> FindTurns(const std::vector<VehicleStep>& steps, const TurnDetectorOptions& options);

/// Divides the steps into segments, in order, without gaps or overlap.
std::vector<PathSegment> SplitIntoSegments(const std::vector<VehicleStep>& steps, const PathSegmentOptions& options);

/// The steps of a segment.
inline std::span<const VehicleStep> StepsOf(std::span<const VehicleStep> steps, int first, int last) {
  return steps.subspan(first, last - first + 1);
}

}  // namespace turnscale
