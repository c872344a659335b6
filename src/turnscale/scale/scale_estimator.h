// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/scale/car_prior.h"
#include "turnscale/scale/scale_filter.h"
#include "turnscale/scale/turn_test.h"

namespace turnscale {

struct ScaleEstimatorOptions {
  PathSegmentOptions segments;
  EvidenceOptions evidence;
  DriftOptions drift;
  TurnTestOptions test;
  /// A segment that disagrees with the drive by more than this many sigmas loses weight (Huber).
  double huber = 1.5;
  /// A drive whose scale is known worse than this (relative) at its best has none.
  double max_sigma = 0.15;
  /// Where the scale follows single turns, one whose sigma is this many times the best turn's is not followed.
  double max_sigma_ratio = 3;
  /// The steps are known to be wrong beyond their noise, as by a calibration that the images contradict: the scale
  /// follows each turn's own, as where turns contradict each other.
  bool follow_turns = false;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// What a turn says of the scale, and what became of it.
struct TurnEstimate {
  int segment = 0;  ///< place in ScaleEstimate::segments
  int first_step = 0;
  int last_step = 0;
  double angle = 0;  ///< rad, positive to the right
  bool used = false;
  std::string reason;          ///< why it was not used; empty where it was
  double own = 0;              ///< metres per unit that this turn shows by itself; 0 where it shows none
  double own_sigma = 0;        ///< relative
  double as_given = 0;         ///< as `own`, but with the car's constants as they were given; may be infinite
  double as_given_sigma = 0;   ///< relative
  bool followed = false;       ///< where the scale follows single turns: this one, at `as_given`
  double smoothed = 0;         ///< metres per unit of the drive's scale there
  double smoothed_sigma = 0;   ///< relative
  double lever_arm_units = 0;  ///< effective lever arm, odometry units
  double speed_units = 0;      ///< root mean square, odometry units per second; 0 where times are unknown
  double weight = 0;           ///< 1, below where the turn disagrees with the rest
  double deviation = 0;        ///< ln(smoothed / own) in standard deviations
};

/// What the drive says of the car beyond what was given, with standard deviations.
struct CarRefinement {
  double yaw_error = 0;  ///< what the camera's rotation has too little, rad: it looks so much further right
  double yaw_error_sigma = 0;
  double side_slip = 0;             ///< c in L_eff = L - c v^2, s^2/m
  double side_slip_sigma = 0;       ///< 0 where c was given as known exactly
  bool side_slip_at_bound = false;  ///< the drive asks for tyres that slip inwards: c is held at 0
};

/// The scale of a drive, segment by segment.
struct ScaleEstimate {
  std::vector<PathSegment> segments;
  std::vector<ScaleBelief> smoothed;  ///< one a segment, from the whole drive; sigma includes what the test adds
  double length_sigma = 0;            ///< relative standard deviation of the path's length in metres
  CarRefinement car;
  std::vector<TurnEstimate> turns;
  TurnTest test;  ///< do the turns agree with the estimate? `worst_turn` is a place in `turns`
  bool fell_back =
      false;  ///< they do not, or it did not converge, or `follow_turns`: the scale follows each turn's own
  bool converged = false;
};

/// The estimate, or one line of text that says why there is none.
struct ScaleEstimateResult {
  std::optional<ScaleEstimate> estimate;
  std::string reason;
  std::vector<TurnEstimate> turns;  ///< found, where there is no estimate
};

/// Maximum a posteriori scale of a drive from its steps. Each turn enters once, with its own likelihood: its effective
/// lever arm in units. Unknowns are the log-scale, which drifts, and three constants with physical priors: the yaw that
/// Q lacks, the tyres' slip, and the lever arm. Time is linear in the number of steps.
///
/// Every turn's own scale is then tested against the estimate (TurnTest). Where they disagree beyond chance, the scale
/// follows the turns, and sigma covers the disagreement.
ScaleEstimateResult EstimateScale(const std::vector<VehicleStep>& steps, const CarPrior& car,
                                  const ScaleEstimatorOptions& options);

}  // namespace turnscale
