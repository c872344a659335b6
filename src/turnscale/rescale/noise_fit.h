// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/rescale/scale_filter.h"

namespace turnscale {

/// What is known of a standard deviation before the drive is seen: it lies within bounds, and about a typical value.
struct NoisePrior {
  double low = 0;
  double high = 0;
  double typical = 0;
  double spread = 0;  ///< standard deviation of its logarithm

  /// Throws InputError that names `field` when a value makes no sense.
  void Check(const char* field) const;
};

/// Bounds of the maximum likelihood search. The weak priors only matter on drives with a handful of turns, where the
/// likelihood alone would run to a bound.
struct NoiseFitOptions {
  NoisePrior lever{0.01, 0.1, 0.03, 0.7};             ///< relative, turn by turn
  NoisePrior direction{0.0004, 0.007, 0.0012, 1.0};   ///< rad, stretch by stretch: 0.02...0.4 deg
  NoisePrior per_distance{0.0005, 0.06, 0.008, 1.2};  ///< of log-scale in 100 m
  NoisePrior per_angle{0.0005, 0.06, 0.008, 1.2};     ///< of log-scale in 90 deg of turning

  void Check() const;
};

/// Typical values of all; no drift of the scale where `drifting` is false.
ScaleNoise TypicalNoise(const NoiseFitOptions& options, bool drifting);

/// The noise at which the drive is most likely, searched one standard deviation after the other from `start`. `at` is
/// where the filter is linearised. Where `start` has no drift, none is searched for.
ScaleNoise FitNoise(const ScaleProblem& problem, const std::vector<DriveState>& at, const ScaleNoise& start,
                    const NoiseFitOptions& options);

}  // namespace turnscale
