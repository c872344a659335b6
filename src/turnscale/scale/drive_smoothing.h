// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/scale/scale_evidence.h"
#include "turnscale/scale/scale_filter.h"
#include "turnscale/scale/turn_selection.h"

namespace turnscale {

/// The smoothed scale of a drive, before its turns are tested.
struct SmoothedDrive {
  ScaleProblem problem;    ///< that was solved: with robust weights, without the turns that are left out
  SmoothedScale smoothed;  ///< with c at least 0; covariances and gains are those of the unbounded fit
  ScaleBelief car;         ///< at the end of the drive, of the unbounded fit
  bool converged = false;

  /// c of the unbounded fit, s^2/m; may be negative.
  double side_slip() const { return car.mean[kSlip]; }
};

/// Maximum a posteriori estimate with robust weights: Gauss-Newton by repeated smoothing (SmoothScale). Which turns are
/// usable depends on the direction of travel and the slip, so the turns are selected again with the estimate,
/// until the selection stays; where selections alternate, turns that were left out are not taken in again.
///
/// `problem`: segments, options and drift; evidence, weights and prior are set here. `gathered`: the evidence of all
/// segments. `selection`: the turns to begin with; StartingLogScale must not be empty. `huber`:
/// ScaleEstimatorOptions::huber.
SmoothedDrive SmoothDrive(ScaleProblem problem, const std::vector<SegmentEvidence>& gathered, const CarPrior& car,
                          double huber, TurnSelection selection);

}  // namespace turnscale
