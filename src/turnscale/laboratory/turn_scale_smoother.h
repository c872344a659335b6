// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/kinematics/turn_detector.h"

namespace turnscale {

/// What one turn says of the unit of length.
struct ObservedTurn {
  TurningRegion region;
  double metres_per_unit = 0;
  double relative_sigma = 0;
};

/// Gives each turn the metres per unit that all turns together say: Kalman filter and Rauch-Tung-Striebel smoother on
/// the logarithm, which walks randomly along the path by `drift_per_root_metre` (relative, after one metre). `centres`
/// are those of the keyframes.
void SmoothTurnScales(const std::vector<Eigen::Vector3d>& centres, double drift_per_root_metre,
                      std::vector<ObservedTurn>& turns);

}  // namespace turnscale
