// SPDX-License-Identifier: MIT
#include "turnscale/mapping/lens_refinement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/local_bundle_adjustment.h"

namespace turnscale {
namespace {

constexpr int kFewestInWindow = 3;  // of a landmark in the window: two fit a point whatever the lens does

// Cost that is left when poses and points have followed the correction; NaN where they cannot. Changes the problem.
double ProfileCost(const Pinhole& pinhole, double from, double to, BundleProblem& problem) {
  for (BundleObservation& seen : problem.observations)
    seen.pixel = CorrectRadially(pinhole, to, UndoRadialCorrection(pinhole, from, seen.pixel));
  BundleOptions options;
  options.max_iterations = 12;
  options.relative_cost_tolerance = 1e-5;
  const std::optional<BundleSummary> summary = TryAdjustBundle(options, problem);
  return summary ? summary->final_cost : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

void LensRefinementOptions::Check() const {
  if (window < 3) throw InputError("lens.window: has to be at least 3 keyframes");
  if (!(min_turn_deg >= 0)) throw InputError("lens.min_turn_deg: must not be negative");
  if (!(prior_sigma > 0)) throw InputError("lens.prior_sigma: has to be positive");
  if (!(step > 0)) throw InputError("lens.step: has to be positive");
  if (!(pixel_sigma > 0)) throw InputError("lens.pixel_sigma: has to be positive");
}

LensRefinement::LensRefinement(const LensRefinementOptions& options)
    : options_(options),
      information_(1.0 / (options.prior_sigma * options.prior_sigma)),
      next_keyframe_(options.window - 1) {}

double LensRefinement::sigma() const { return 1.0 / std::sqrt(information_); }

bool LensRefinement::Observe(const Map& map, double applied) {
  const int latest = static_cast<int>(map.keyframes.size()) - 1;
  if (!options_.enabled || latest < next_keyframe_) return false;
  next_keyframe_ = latest + options_.window / 2;
  const int first = latest - options_.window + 1;
  if (first < StartOfMap(map, first)) return false;
  if (InDegrees(TurnBetween(map, first, latest)) < options_.min_turn_deg) return false;
  WindowProblem window = MakeWindowProblem(map, {first, first + 1, kFewestInWindow}, options_.pixel_sigma);
  if (window.landmarks.empty()) return false;

  // The others start at the minimum for the present correction, which is close to theirs.
  const double here = ProfileCost(map.pinhole, applied, correction_, window.bundle);
  BundleProblem shifted = window.bundle;
  const double below = ProfileCost(map.pinhole, correction_, correction_ - options_.step, shifted);
  shifted = std::move(window.bundle);
  const double above = ProfileCost(map.pinhole, correction_, correction_ + options_.step, shifted);
  const double slope = (above - below) / (2 * options_.step);
  const double curvature = (above - 2 * here + below) / (options_.step * options_.step);
  if (!(curvature > 0)) return false;
  // Windows overlap by half, so that each observation has its say twice.
  information_ += 0.5 * curvature;
  weighted_estimate_ += 0.5 * (curvature * correction_ - slope);
  // Far from where it was measured a parabola is not to be trusted: the next window looks a step further.
  const double estimate = weighted_estimate_ / information_;
  correction_ = std::clamp(estimate, correction_ - options_.step, correction_ + options_.step);
  return true;
}

}  // namespace turnscale
