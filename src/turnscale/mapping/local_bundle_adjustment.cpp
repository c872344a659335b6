// SPDX-License-Identifier: MIT
#include "turnscale/mapping/local_bundle_adjustment.h"

#include <algorithm>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// The first keyframe since tracking was lost last: nothing before it shares a landmark with what follows.
int StartOfMap(const Map& map) {
  int start = static_cast<int>(map.keyframes.size()) - 1;
  while (start > 0 && !map.keyframes[start].after_gap) --start;
  return start;
}

}  // namespace

void LocalBundleOptions::Check() const {
  if (window < 2) throw InputError("local_bundle.window: has to be at least 2 keyframes");
  if (anchors < 1) throw InputError("local_bundle.anchors: has to be at least 1 keyframe");
  if (!(pixel_sigma > 0)) throw InputError("local_bundle.pixel_sigma: has to be positive");
  if (max_iterations < 1) throw InputError("local_bundle.max_iterations: has to be at least 1");
}

LocalBundleResult AdjustLocalWindow(const LocalBundleOptions& options, Map& map) {
  const int keyframes = static_cast<int>(map.keyframes.size());
  const int start = StartOfMap(map);
  const int first_free = std::max(start + 1, keyframes - options.window);
  const int first_anchor = std::max(start, first_free - options.anchors);

  LocalBundleResult result;
  for (int k = first_free; k < keyframes; ++k)
    for (const KeyframeObservation& seen : map.keyframes[k].observations)
      if (map.landmarks[seen.landmark].valid) result.landmarks.push_back(seen.landmark);
  std::ranges::sort(result.landmarks);
  const auto repeated = std::ranges::unique(result.landmarks);
  result.landmarks.erase(repeated.begin(), repeated.end());

  BundleProblem problem;
  problem.pinhole = map.pinhole;
  for (int k = first_anchor; k < keyframes; ++k) {
    problem.camera_from_world.push_back(map.keyframes[k].camera_from_world);
    problem.camera_is_fixed.push_back(k < first_free ? 1 : 0);
  }
  for (const int index : result.landmarks) {
    const int point = static_cast<int>(problem.points.size());
    problem.points.push_back(map.landmarks[index].position);
    for (const LandmarkObservation& seen : map.landmarks[index].observations)
      if (seen.keyframe >= first_anchor)
        problem.observations.push_back({seen.keyframe - first_anchor, point, seen.pixel, options.pixel_sigma});
  }

  BundleOptions bundle_options;
  bundle_options.max_iterations = options.max_iterations;
  bundle_options.relative_cost_tolerance = 1e-4;
  result.summary = AdjustBundle(bundle_options, problem);
  for (int k = first_free; k < keyframes; ++k)
    map.keyframes[k].camera_from_world = problem.camera_from_world[k - first_anchor];
  for (size_t i = 0; i < result.landmarks.size(); ++i) map.landmarks[result.landmarks[i]].position = problem.points[i];
  return result;
}

}  // namespace turnscale
