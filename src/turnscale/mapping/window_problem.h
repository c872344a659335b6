// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// Keyframes `first`...latest of a map: those before `first_free` hold still, the others move.
struct Window {
  int first = 0;
  int first_free = 1;
  /// Least number of keyframes of the window that have to see a landmark.
  int min_observations = 2;
};

/// A stretch of the map as bundle adjustment takes it.
struct WindowProblem {
  Window window;
  BundleProblem bundle;        ///< camera i is keyframe window.first + i, point i is landmark landmarks[i]
  std::vector<int> landmarks;  ///< seen by a free keyframe; ascending
};

/// The first keyframe since tracking was lost last, but none before `earliest`: nothing before a loss shares a landmark
/// with what follows.
int StartOfMap(const Map& map, int earliest = 0);

WindowProblem MakeWindowProblem(const Map& map, const Window& window, double pixel_sigma);

/// Brings what bundle adjustment found back into the map.
void WriteBack(const WindowProblem& problem, Map& map);

}  // namespace turnscale
