// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/mapping/map.h"
#include "turnscale/odometry/frame_history.h"
#include "turnscale/odometry/refined_scale.h"

namespace turnscale {

/// Standard deviation of the length of a path that is not measured for so long (seconds), metres. It is interpolated
/// between the speeds before and after (`both_ends`), or extrapolated from one of them: 0.15 and 0.4 m/s^2 times the
/// time squared, at most 10 m/s times the time, from KITTI's ground truth for 0.5 to 10 s (22,000 frames).
double GapLengthSigma(double seconds, bool both_ends);

/// By how much a car that turns by `turn` (rad) in so many seconds falls short of the way at the mean of the speeds
/// before and after, metres: it brakes for the corner. 0.18 m/s^2 times the time squared times the turn squared, at
/// most 0.25 m/s^2 times the time squared, of which not more than 5 s count; from KITTI's ground truth (docs/gaps.md).
double CornerSlowing(double seconds, double turn);

/// The map predicts the motion across a loss of tracking from the speed before it. Makes its length the mean of that
/// and of the length at the speed after it, now that this is known, less what a corner takes (CornerSlowing, at most a
/// quarter); the side whose scale is known better counts for more.
/// `ends`: FrameHistory::MeasuredEnds. Sets the standard deviation of the path's length up to `end_time` (seconds) due
/// to all gaps.
void BridgeGaps(const Map& map, const std::vector<MeasuredEnd>& ends, double end_time, RefinedScale& refined);

}  // namespace turnscale
