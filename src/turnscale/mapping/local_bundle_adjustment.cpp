// SPDX-License-Identifier: MIT
#include "turnscale/mapping/local_bundle_adjustment.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/mapping/window_problem.h"

namespace turnscale {

void LocalBundleOptions::Check() const {
  if (window < 2) throw InputError("local_bundle.window: has to be at least 2 keyframes");
  if (anchors < 1) throw InputError("local_bundle.anchors: has to be at least 1 keyframe");
  if (!(pixel_sigma > 0)) throw InputError("local_bundle.pixel_sigma: has to be positive");
  if (!(relative_cost_tolerance > 0)) throw InputError("local_bundle.relative_cost_tolerance: has to be positive");
  if (!(initial_damping >= 0)) throw InputError("local_bundle.initial_damping: is negative or not a number");
  if (max_iterations < 1) throw InputError("local_bundle.max_iterations: has to be at least 1");
}

LocalBundleResult AdjustLocalWindow(const LocalBundleOptions& options, Map& map) {
  const int keyframes = static_cast<int>(map.keyframes.size());
  return AdjustFrom(options, keyframes - options.window, map);
}

LocalBundleResult AdjustFrom(const LocalBundleOptions& options, int first, Map& map) {
  const int start = StartOfMap(map, std::max(0, first - options.anchors));
  const int first_free = std::max(start + 1, first);
  const int first_anchor = std::max(start, first_free - options.anchors);
  WindowProblem problem = MakeWindowProblem(map, {first_anchor, first_free}, options.pixel_sigma);
  BundleOptions bundle_options;
  bundle_options.max_iterations = options.max_iterations;
  bundle_options.relative_cost_tolerance = options.relative_cost_tolerance;
  bundle_options.initial_damping = options.initial_damping;
  LocalBundleResult result;
  const std::optional<BundleSummary> summary = TryAdjustBundle(bundle_options, problem.bundle);
  if (!summary) return result;
  result.summary = *summary;
  WriteBack(problem, map);
  result.landmarks = std::move(problem.landmarks);
  return result;
}

}  // namespace turnscale
