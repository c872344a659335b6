// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/rescale/scale_estimator.h"
#include "turnscale/rescale/stretch.h"
#include "turnscale/rescale/sway_step.h"

namespace turnscale {

/// What a turn says of the scale, and what became of it.
struct RescaledTurn {
  int first_pose = 0;
  int last_pose = 0;
  double angle = 0;                ///< rad, positive to the right
  double speed = 0;                ///< m/s; 0 where times are unknown
  double metres_per_unit = 0;      ///< that this turn shows alone; 0 where it contradicts the model
  double sigma = 0;                ///< of that, relative
  double smoothed = 0;             ///< metres per unit from the whole drive
  double smoothed_sigma = 0;       ///< relative
  double effective_lever_arm = 0;  ///< seen at the smoothed scale, metres
  bool used = false;               ///< false where it is too fast: side slip leaves too little of the lever arm
  double weight = 0;               ///< about 1; well below for a turn that disagrees with the rest
};

/// All turns of a drive. `common_sigma` (relative) is what they have in common.
std::vector<RescaledTurn> DescribeTurns(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                        const ScaleEstimate& estimate, double common_sigma);

}  // namespace turnscale
