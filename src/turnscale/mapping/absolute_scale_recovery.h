// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/mapping/map.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/mapping/recovery_problem.h"

namespace turnscale {

struct ScaleRecoveryOptions {
  /// Standard deviation of a tracked pixel, pixels.
  double pixel_sigma = kTrackedPixelSigma;
  /// With measured turns (TurnScale::sigma), which only the laboratory has, the pixel sigma is multiplied by this:
  /// pixel errors of a track are correlated, since all its views are aligned to one patch, so that ten views carry
  /// about as much information as one. 1: independent errors.
  double pixel_sigma_inflation = 3;
  int max_iterations = 30;
  /// Residuals (in sigmas) beyond this are weighted linearly (Huber).
  double huber_threshold = 2.0;
  /// Largest ratio of the path lengths after and before the adjustment, either way; beyond it, the adjustment has
  /// diverged and the first guess is kept.
  double max_stretch = 1.5;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Result for a range of the map between two losses of tracking.
struct RangeRecovery {
  KeyframeRange range;
  bool adjusted = false;  ///< false: scaled by the first guess only
  std::string reason;     ///< why it was not adjusted; empty where it was
  BundleSummary summary;
};

struct ScaleRecoveryResult {
  std::vector<RangeRecovery> ranges;
  /// Lengths at keyframe k are `factors[k]` times what they were; one for every keyframe of the map.
  std::vector<double> factors;
};

/// Absolute scale recovery (24)-(30): scales all keyframes and landmarks of a finished map to metres.
///
/// Give all turns in the order of time. A first guess scales each step: as the turn says within turns, passing from
/// turn to turn between them (F_u), and like the nearest turn at the ends. Then reprojection errors are minimised over
/// centres and points, with rotations and the first keyframe fixed and the length of every step of a turn held (or
/// weighed: TurnScale::sigma). Steps that bridge a loss of tracking are scaled and not adjusted.
///
/// The result does not depend on the map's unit of length. Throws InternalError when steps are out of range or out
/// of order, a factor is not positive, or a sigma negative.
ScaleRecoveryResult RecoverAbsoluteScale(const ScaleRecoveryOptions& options, const std::vector<TurnScale>& turns,
                                         Map& map);

}  // namespace turnscale
