// SPDX-License-Identifier: MIT
#include "turnscale/mapping/local_bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "turnscale/base/error.h"
#include "turnscale/mapping/end_of_window.h"
#include "turnscale/mapping/map_scaling.h"

namespace turnscale {
namespace {

// Of a window, and of its anchors: far more than can be adjusted together, and the sum of the two is a number.
constexpr int kMostKeyframes = 10'000;

std::vector<Eigen::Vector3d> CentresOf(const WindowProblem& problem, const Map& map) {
  std::vector<Eigen::Vector3d> centres = KeyframeCentres(map, problem.window.first);
  centres.resize(problem.bundle.camera_from_world.size());
  return centres;
}

double FirstStep(const BundleProblem& bundle) {
  return (bundle.camera_from_world[1].inverse().translation - bundle.camera_from_world[0].inverse().translation).norm();
}

// Scales the window about its first camera until the first step is as long as it was. The images do not tell the unit,
// and an adjustment of noisy points shrinks it.
void HoldUnit(double first_step, BundleProblem& bundle) {
  const double scale = first_step / FirstStep(bundle);
  if (!std::isfinite(scale) || scale == 0) return;
  const Eigen::Vector3d origin = bundle.camera_from_world[0].inverse().translation;
  const Similarity new_from_old{scale, Eigen::Quaterniond::Identity(), (1 - scale) * origin};
  for (size_t i = 1; i < bundle.camera_from_world.size(); ++i)
    bundle.camera_from_world[i] = Moved(bundle.camera_from_world[i], new_from_old);
  for (Eigen::Vector3d& point : bundle.points) point = new_from_old * point;
}

}  // namespace

int StartOfMap(const Map& map, int earliest) {
  int start = CountKeyframes(map) - 1;
  while (start > earliest && !map.keyframes[start].after_gap) --start;
  return start;
}

WindowProblem MakeWindowProblem(const Map& map, const Window& window, double pixel_sigma) {
  const int keyframes = CountKeyframes(map);
  WindowProblem problem;
  problem.window = window;
  problem.starts_map =
      window.first_free == window.first + 1 && (window.first == 0 || map.keyframes[window.first].after_gap);
  const auto in_window = [&](const LandmarkObservation& seen) { return seen.keyframe >= window.first; };
  size_t observations = 0;
  for (const int landmark : LandmarksSeen(map, window.first_free, keyframes - 1)) {
    const auto count = std::ranges::count_if(map.landmarks[landmark].observations, in_window);
    if (count < 2) continue;
    problem.landmarks.push_back(landmark);
    observations += static_cast<size_t>(count);
  }

  BundleProblem& bundle = problem.bundle;
  bundle.pinhole = map.camera.pinhole;
  for (int k = window.first; k < keyframes; ++k) {
    bundle.camera_from_world.push_back(map.keyframes[k].camera_from_world);
    bundle.camera_is_fixed.push_back(k < window.first_free ? 1 : 0);
  }
  bundle.points.reserve(problem.landmarks.size());
  bundle.observations.reserve(observations);
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
  const int last = problem.window.first + static_cast<int>(problem.bundle.camera_from_world.size()) - 1;
  const RigidTransform old_camera = map.keyframes[last].camera_from_world;
  const bool has_later = last + 1 < CountKeyframes(map);
  std::vector<Eigen::Vector3d> before;
  if (has_later) before = CentresOf(problem, map);
  for (size_t i = 0; i < problem.bundle.camera_from_world.size(); ++i)
    if (problem.bundle.camera_is_fixed[i] == 0)
      map.keyframes[problem.window.first + i].camera_from_world = problem.bundle.camera_from_world[i];
  if (has_later) {
    const double scale = ScaleOfEnd(before, CentresOf(problem, map)).value_or(1.0);
    MoveFrom(last + 1, MoveOfEnd(old_camera, map.keyframes[last].camera_from_world, scale), problem.landmarks, map);
  }
  for (size_t i = 0; i < problem.landmarks.size(); ++i)
    map.landmarks[problem.landmarks[i]].position = problem.bundle.points[i];
}

void LocalBundleOptions::Check() const {
  if (window < 2 || window > kMostKeyframes)
    throw InputError("window: has to be from 2 to " + std::to_string(kMostKeyframes) + " keyframes");
  if (anchors < 1 || anchors > kMostKeyframes)
    throw InputError("anchors: has to be from 1 to " + std::to_string(kMostKeyframes) + " keyframes");
  if (!(pixel_sigma > 0)) throw InputError("pixel_sigma: has to be positive");
  if (!(relative_cost_tolerance > 0)) throw InputError("relative_cost_tolerance: has to be positive");
  if (!(initial_damping >= 0)) throw InputError("initial_damping: must not be negative");
  if (max_iterations < 1) throw InputError("max_iterations: has to be at least 1");
}

LocalBundleResult AdjustLocalWindow(const LocalBundleOptions& options, Map& map) {
  const int keyframes = CountKeyframes(map);
  return AdjustFrom(options, keyframes - options.window, map);
}

WindowProblem MakeLocalWindow(const LocalBundleOptions& options, int first, const Map& map) {
  const int start = StartOfMap(map, std::max(0, first - options.anchors));
  const int first_free = std::max(start + 1, first);
  const int first_anchor = std::max(start, first_free - options.anchors);
  return MakeWindowProblem(map, {first_anchor, first_free}, options.pixel_sigma);
}

std::optional<BundleSummary> AdjustWindow(const LocalBundleOptions& options, WindowProblem& window) {
  BundleOptions bundle_options;
  bundle_options.max_iterations = options.max_iterations;
  bundle_options.relative_cost_tolerance = options.relative_cost_tolerance;
  bundle_options.initial_damping = options.initial_damping;
  bundle_options.use_exact_hessian = options.use_exact_hessian;
  const bool holds_unit = window.starts_map && window.bundle.camera_from_world.size() > 1;
  const double first_step = holds_unit ? FirstStep(window.bundle) : 0;
  const std::optional<BundleSummary> summary = TryAdjustBundle(bundle_options, window.bundle);
  if (summary && holds_unit) HoldUnit(first_step, window.bundle);
  return summary;
}

LocalBundleResult AdjustFrom(const LocalBundleOptions& options, int first, Map& map) {
  WindowProblem problem = MakeLocalWindow(options, first, map);
  LocalBundleResult result;
  const std::optional<BundleSummary> summary = AdjustWindow(options, problem);
  result.failed = !summary;
  if (!summary) return result;
  result.summary = *summary;
  WriteBack(problem, map);
  result.landmarks = std::move(problem.landmarks);
  return result;
}

}  // namespace turnscale
