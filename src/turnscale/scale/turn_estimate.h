// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/scale/scale_evidence.h"
#include "turnscale/scale/scale_filter.h"

namespace turnscale {

/// The scale from one turn, and how it was used. Scales are in metres per unit.
struct TurnEstimate {
  // As the turn shows it (DescribeTurns).
  int segment = 0;  ///< place in ScaleEstimate::segments
  int first_step = 0;
  int last_step = 0;
  double angle = 0;  ///< rad, positive to the right
  bool used = false;
  std::string reason;          ///< why it was not used; empty if it was
  double lever_arm_units = 0;  ///< effective lever arm, odometry units
  /// Root mean square where the turn goes one way (PooledLine::mean_square_speed), odometry units per second; 0 where
  /// times are unknown.
  double speed_units = 0;
  double as_given = 0;  ///< single-turn scale with the car's constants as given; may be infinite; 0 if there is none
  double as_given_relative_sigma = 0;

  // With what the drive's estimate says of the car.
  double own = 0;  ///< single-turn scale with the car's constants as refined; `as_given` while they are not
  double own_relative_sigma = 0;
  double weight = 0;  ///< Huber weight: below 1 if the turn disagrees with the others
  /// Effective lever arm less the one that the smoothed scale lets expect, in standard deviations. It has the sign of
  /// ln(smoothed / own).
  double deviation = 0;

  // In the result.
  bool used_singly = false;  ///< single-turn scales are used, `as_given` of this turn among them
  double smoothed = 0;       ///< scale of the estimate at the turn
  double smoothed_relative_sigma = 0;
};

/// The turns of a drive, without what the drive's estimate says of them. `as_given`: the constants of the car as given.
std::vector<TurnEstimate> DescribeTurns(const ScaleProblem& problem, const DriveState& as_given);

/// No turn is used, for this reason; turns that were not used before keep theirs.
void LeaveOutTurns(const std::string& reason, std::vector<TurnEstimate>& turns);

}  // namespace turnscale
