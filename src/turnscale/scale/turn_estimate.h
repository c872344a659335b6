// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/scale/scale_evidence.h"
#include "turnscale/scale/scale_filter.h"

namespace turnscale {

/// The scale from one turn, and how it was used.
struct TurnEstimate {
  int segment = 0;  ///< place in ScaleEstimate::segments
  int first_step = 0;
  int last_step = 0;
  double angle = 0;  ///< rad, positive to the right
  bool used = false;
  std::string reason;          ///< why it was not used; empty if it was
  double own = 0;              ///< single-turn scale, metres per unit; 0 if there is none
  double own_sigma = 0;        ///< relative
  double as_given = 0;         ///< as `own`, with the car's constants as given (FollowTurns); may be infinite
  double as_given_sigma = 0;   ///< relative
  bool followed = false;       ///< with single-turn scales: this turn is used, at `as_given`
  double smoothed = 0;         ///< smoothed scale there, metres per unit
  double smoothed_sigma = 0;   ///< relative
  double lever_arm_units = 0;  ///< effective lever arm, odometry units
  /// Root mean square where the turn goes one way (PooledLine::mean_square_speed), odometry units per second; 0 where
  /// times are unknown.
  double speed_units = 0;
  double weight = 0;     ///< Huber weight: below 1 if the turn disagrees with the others
  double deviation = 0;  ///< ln(smoothed / own) in standard deviations
};

/// The turns of a drive, without what the drive's estimate says of them. `as_given`: the constants of the car as given.
std::vector<TurnEstimate> DescribeTurns(const ScaleProblem& problem, const DriveState& as_given);

/// No turn is used, for this reason; turns that were not used before keep theirs.
void LeaveOutTurns(const std::string& reason, std::vector<TurnEstimate>& turns);

}  // namespace turnscale
