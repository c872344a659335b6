// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/mapping/synthetic_map.h"
#include "turnscale/scale/map_scaling.h"

namespace turnscale {

/// Makes the map as an odometry would give it whose unit drifts: step j is `step_factors[j]` times its true length.
inline void DriftMap(const std::vector<double>& step_factors, Map& map) {
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(map);
  const std::vector<Eigen::Vector3d> after = ScaleSteps(before, 0, step_factors);
  std::vector<int> landmarks;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) landmarks.push_back(static_cast<int>(i));
  CarryLandmarks(before, after, 0, KeyframeFactors(before, after, 0, step_factors), landmarks, map);
  SetKeyframeCentres(after, map);
}

}  // namespace turnscale
