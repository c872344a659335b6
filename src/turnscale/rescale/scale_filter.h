// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/rescale/scale_evidence.h"

namespace turnscale {

/// Noise of a drive: what its scale does between turns, and what the model leaves in each stretch.
struct ScaleNoise {
  StretchNoise stretch;
  double per_distance = 0;  ///< standard deviation that the log-scale gathers over 100 m
  double per_angle = 0;     ///< and over 90 degrees of turning
};

/// A drive as the estimator sees it: one unknown log-scale a stretch, three more unknowns for all.
struct ScaleProblem {
  double lever_arm = 0;  ///< metres
  Belief prior;          ///< before the first stretch
  std::vector<StretchObservation> observations;
};

struct ScaleHistory {
  std::vector<Belief> beliefs;  ///< one a stretch
  double log_likelihood = 0;    ///< of all observations, up to a constant that the noise does not touch
};

/// Log-likelihood of a Kalman filter along the drive, linearised at given states (one a stretch).
double ScaleLogLikelihood(const ScaleProblem& problem, const ScaleNoise& noise, const std::vector<DriveState>& at);

/// That filter and the Rauch-Tung-Striebel smoother: a belief holds what the whole drive tells. With the linearisation
/// moved to the answer and this repeated, it is Gauss-Newton on the maximum a posteriori problem, in time linear in the
/// number of stretches (Bell 1994, The iterated Kalman smoother as a Gauss-Newton method).
ScaleHistory SmoothScale(const ScaleProblem& problem, const ScaleNoise& noise, const std::vector<DriveState>& at);

/// Iterated extended Kalman filter, each stretch linearised at what is known with it: a belief holds what is known up
/// to and with its stretch. The log-scale starts where the first turn alone has it; up to there beliefs keep the
/// prior's covariance.
ScaleHistory FilterScale(const ScaleProblem& problem, const ScaleNoise& noise);

}  // namespace turnscale
