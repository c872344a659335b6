// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// Keyframes `first`...latest of a map: those before `first_free` hold still, the others move.
struct Window {
  int first = 0;
  int first_free = 1;
};

/// A stretch of the map as bundle adjustment takes it.
struct WindowProblem {
  Window window;
  BundleProblem bundle;        ///< camera i is keyframe window.first + i, point i is landmark landmarks[i]
  std::vector<int> landmarks;  ///< seen by a free keyframe, and by two of the window; ascending
  bool starts_map = false;     ///< only the first keyframe of the map, or after a gap, holds still
};

/// The first keyframe since tracking was lost last, but none before `earliest`: nothing before a loss shares a landmark
/// with what follows.
int StartOfMap(const Map& map, int earliest = 0);

WindowProblem MakeWindowProblem(const Map& map, const Window& window, double pixel_sigma);

/// Brings what bundle adjustment found back into the map. Keyframes that have been added since the problem was made
/// follow the problem's latest one, as do landmarks that are not in the problem but seen by them; lengths change by
/// ScaleOfEnd.
void WriteBack(const WindowProblem& problem, Map& map);

struct LocalBundleOptions {
  /// Latest keyframes that move; at most 10000.
  int window = 10;
  /// Earlier keyframes that see the window's landmarks and stand still; they hold the scale. At most 10000.
  int anchors = 10;
  /// Standard deviation of a tracked pixel, pixels.
  double pixel_sigma = kTrackedPixelSigma;
  int max_iterations = 6;
  /// An iteration that lowers the cost by less than this share is the last.
  double relative_cost_tolerance = 1e-4;
  /// First damping, relative to the diagonal of the normal equations. With a small one, the first steps also change
  /// what is weakly observable, such as the drift of the scale along a section: for windows that are close to their
  /// minimum already.
  double initial_damping = 1e-4;
  /// See BundleOptions.
  bool use_exact_hessian = true;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

struct LocalBundleResult {
  BundleSummary summary;
  std::vector<int> landmarks;  ///< those that took part, ascending
  bool failed = false;         ///< the window contains NaN
};

/// The keyframes from `first` to the latest and the landmarks they see; earlier keyframes that see the same landmarks
/// hold still. The first keyframe of the map, or after a gap in the tracking, never moves.
WindowProblem MakeLocalWindow(const LocalBundleOptions& options, int first, const Map& map);

/// Adjusts a window without changing the map; WriteBack does that. At the start of the map, the first step keeps its
/// length: the images leave the unit of length free. Returns nothing and leaves the window unchanged if it contains
/// NaN.
std::optional<BundleSummary> AdjustWindow(const LocalBundleOptions& options, WindowProblem& window);

/// Adjusts the latest keyframes of the map and the landmarks they see. A window that contains NaN stays as it is,
/// and no landmark takes part.
LocalBundleResult AdjustLocalWindow(const LocalBundleOptions& options, Map& map);

/// The same with all keyframes from `first` to the latest moving.
LocalBundleResult AdjustFrom(const LocalBundleOptions& options, int first, Map& map);

}  // namespace turnscale
