// SPDX-License-Identifier: MIT
#include "turnscale/mapping/window_problem.h"

#include <algorithm>

namespace turnscale {

int StartOfMap(const Map& map, int earliest) {
  int start = static_cast<int>(map.keyframes.size()) - 1;
  while (start > earliest && !map.keyframes[start].after_gap) --start;
  return start;
}

WindowProblem MakeWindowProblem(const Map& map, const Window& window, double pixel_sigma) {
  const int keyframes = static_cast<int>(map.keyframes.size());
  WindowProblem problem;
  problem.window = window;
  for (int k = window.first_free; k < keyframes; ++k)
    for (const KeyframeObservation& seen : map.keyframes[k].observations)
      if (map.landmarks[seen.landmark].valid) problem.landmarks.push_back(seen.landmark);
  std::ranges::sort(problem.landmarks);
  problem.landmarks.erase(std::unique(problem.landmarks.begin(), problem.landmarks.end()), problem.landmarks.end());
  const auto in_window = [&](const LandmarkObservation& seen) { return seen.keyframe >= window.first; };
  std::erase_if(problem.landmarks, [&](int index) {
    return std::ranges::count_if(map.landmarks[index].observations, in_window) < window.min_observations;
  });

  BundleProblem& bundle = problem.bundle;
  bundle.pinhole = map.pinhole;
  for (int k = window.first; k < keyframes; ++k) {
    bundle.camera_from_world.push_back(map.keyframes[k].camera_from_world);
    bundle.camera_is_fixed.push_back(k < window.first_free ? 1 : 0);
  }
  for (const int index : problem.landmarks) {
    const int point = static_cast<int>(bundle.points.size());
    bundle.points.push_back(map.landmarks[index].position);
    for (const LandmarkObservation& seen : map.landmarks[index].observations)
      if (in_window(seen))
        bundle.observations.push_back({seen.keyframe - window.first, point, seen.pixel, pixel_sigma});
  }
  return problem;
}

void WriteBack(const WindowProblem& problem, Map& map) {
  for (size_t i = 0; i < problem.bundle.camera_from_world.size(); ++i)
    if (problem.bundle.camera_is_fixed[i] == 0)
      map.keyframes[problem.window.first + i].camera_from_world = problem.bundle.camera_from_world[i];
  for (size_t i = 0; i < problem.landmarks.size(); ++i)
    map.landmarks[problem.landmarks[i]].position = problem.bundle.points[i];
}

}  // namespace turnscale
