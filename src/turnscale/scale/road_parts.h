// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/scale/scale_evidence.h"

namespace turnscale {

/// Straights with heights above the road are divided into so many more segments than others: the heights observe the
/// drift of the scale within them.
constexpr int kRoadParts = 4;

/// Whether at least half of the steps show the height above the road.
inline bool ShowsRoad(std::span<const VehicleStep> steps) {
  const auto shown = std::count_if(steps.begin(), steps.end(), [](const VehicleStep& step) { return step.height > 0; });
  return shown > 0 && 2 * static_cast<std::size_t>(shown) >= steps.size();
}

/// The longest straight segment that these steps begin.
inline int MostStraightSteps(std::span<const VehicleStep> steps, int max_straight_steps) {
  return ShowsRoad(steps) ? std::max(1, max_straight_steps / kRoadParts) : max_straight_steps;
}

/// Crown and side wind are the same in all parts of a straight: enlarges the sigma of a part's direction so that all
/// parts together determine the direction of travel no better than the undivided straight.
inline void ShareDirection(const EvidenceOptions& options, StraightDirection& part) {
  part.sigma = std::hypot(part.sigma, std::sqrt(kRoadParts - 1.0) * options.straight_direction_sigma);
}

}  // namespace turnscale
