// SPDX-License-Identifier: MIT
#include "turnscale/mapping/lens_refinement.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turnscale/base/error.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/intrinsics_evidence.h"
#include "turnscale/mapping/local_bundle_adjustment.h"

namespace turnscale {
namespace {

using LensChange = IntrinsicsChange::Vector;

constexpr int kFirstIterations = 12;
constexpr int kFurtherIterations = 5;
constexpr int kMostRounds = 10;  // of a window
// Of a window's information that counts: windows overlap by half, so that most observations are in two.
constexpr double kShareOfWindow = 0.5;
// Noise of the images multiplies the variance between windows by about this at most. A far larger factor comes from
// single windows that are wrong, which must not hide a real correction.
constexpr double kMostScatter = 4;
// In standard deviations; a smaller step is not measured again.
constexpr double kNegligibleStep = 0.3;

struct Belief {
  double mean = 0;
  double variance = 0;
  double log_evidence = 0;  // up to a constant that is the same for all priors
};

// For a prior N(0, sigma^2) and a Gaussian likelihood.
Belief Posterior(double sigma, double information, double weighted_estimate) {
  const double variance = sigma * sigma / (1 + information * sigma * sigma);
  return {variance * weighted_estimate, variance,
          0.5 * (variance * weighted_estimate * weighted_estimate - std::log1p(information * sigma * sigma))};
}

// A change of the radial correction alone.
LensChange CorrectionOf(double correction) { return correction * LensChange::Unit(IntrinsicsChange::kCorrection); }

}  // namespace

void LensRefinementOptions::Check() const {
  if (window < 3) throw InputError("window: has to be at least 3 keyframes");
  if (!(min_turn_deg >= 0)) throw InputError("min_turn_deg: must not be negative");
  if (!(prior_sigma > 0)) throw InputError("prior_sigma: has to be positive");
  if (!(accurate_share >= 0 && accurate_share < 1)) throw InputError("accurate_share: has to be from 0 to below 1");
  if (!(accurate_sigma > 0 && accurate_sigma < prior_sigma))
    throw InputError("accurate_sigma: has to be positive and below prior_sigma");
  if (!(step > 0)) throw InputError("step: has to be positive");
  if (max_landmarks < 20) throw InputError("max_landmarks: has to be at least 20");
  if (!(pixel_sigma > 0)) throw InputError("pixel_sigma: has to be positive");
}

LensRefinement::LensRefinement(const LensRefinementOptions& options)
    : options_(options), next_keyframe_(options.window - 1) {
  Update();
}

void LensRefinement::Update() {
  const double scatter = Scatter();
  const Belief accurate = Posterior(options_.accurate_sigma, information_ / scatter, weighted_estimate_ / scatter);
  const Belief off = Posterior(options_.prior_sigma, information_ / scatter, weighted_estimate_ / scatter);
  const double odds =
      options_.accurate_share / (1 - options_.accurate_share) * std::exp(accurate.log_evidence - off.log_evidence);
  const double share = odds / (1 + odds);
  correction_ = share * accurate.mean + (1 - share) * off.mean;
  const double apart = accurate.mean - off.mean;
  sigma_ = std::sqrt(share * accurate.variance + (1 - share) * off.variance + share * (1 - share) * apart * apart);
}

double LensRefinement::Scatter() const {
  if (windows_ < 2) return 1;
  const double squares = weighted_square_ - weighted_estimate_ * weighted_estimate_ / information_;
  return std::clamp(squares / (kShareOfWindow * (windows_ - 1)), 1.0, kMostScatter);
}

std::optional<IntrinsicsProblem> LensRefinement::TakeWindow(const Map& map) {
  const int latest = CountKeyframes(map) - 1;
  if (!options_.enabled || latest < next_keyframe_) return std::nullopt;
  next_keyframe_ = latest + options_.window / 2;
  const int first = latest - options_.window + 1;
  if (first < StartOfMap(map, first)) return std::nullopt;
  if (InDegrees(TurnBetween(map, first, latest)) < options_.min_turn_deg) return std::nullopt;
  // The undistorted image is taken for what a lens with nothing but the correction shows.
  CameraModel camera;
  camera.pinhole = map.camera.pinhole;
  camera.radial_correction = map.camera.radial_correction;
  IntrinsicsWindow window;
  window.first = first;
  window.last = latest;
  window.max_landmarks = options_.max_landmarks;
  IntrinsicsProblem problem(map, camera, window, options_.pixel_sigma);
  if (problem.landmarks() == 0) return std::nullopt;
  return problem;
}

bool LensRefinement::Read(IntrinsicsProblem& window) {
  constexpr int kEntry = IntrinsicsChange::kCorrection;
  window.Change(CorrectionOf(correction_));
  for (int round = 1;; ++round) {
    if (!window.Adjust(round == 1 ? kFirstIterations : kFurtherIterations)) return false;
    const std::optional<IntrinsicsEvidence> evidence = window.Evidence();
    if (!evidence) return false;
    const double at = evidence->at[kEntry];
    const double curvature = evidence->information(kEntry, kEntry);
    if (!(curvature > 0)) return false;
    const double minimum = at - evidence->gradient[kEntry] / curvature;
    const double information = information_ + kShareOfWindow * curvature;
    const double weighted_estimate = weighted_estimate_ + kShareOfWindow * curvature * minimum;
    // Where the parabola is measured does not depend on which of the two priors is believed.
    const Belief off = Posterior(options_.prior_sigma, information, weighted_estimate);
    const double step = off.mean - at;
    if (step * step * information < kNegligibleStep * kNegligibleStep) {
      information_ = information;
      weighted_estimate_ = weighted_estimate;
      weighted_square_ += kShareOfWindow * curvature * minimum * minimum;
      ++windows_;
      Update();
      return true;
    }
    if (round == kMostRounds) return false;
    // The parabola holds only near the place where it was measured.
    window.Follow(*evidence, CorrectionOf(at + std::clamp(step, -options_.step, options_.step)));
  }
}

}  // namespace turnscale
