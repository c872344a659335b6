// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_estimate.h"

#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;
using Matrix = IntrinsicsChange::Matrix;

// Of the radial correction, beyond the term in r^2.
constexpr int kHigherTermsOfLens = 2;
// Degrees of freedom of the Student distribution that windows are taken to follow.
constexpr double kStudentDof = 4;
constexpr int kReweightings = 20;
// Standard deviation of what a distortion beyond its first radial term does to the focal length (relative), the
// principal point (in focal lengths) and the correction, as a share of the correction.
constexpr double kHigherTerms = 0.15;
// Standard deviation of what the linear model gets wrong of a change of the aspect, as a share of how far it is from
// where the windows were linearised.
constexpr double kNonlinearAspect = 0.25;
// Log of the largest aspect that occurs, twice the usual. What looks like more is something else.
constexpr double kMostAspect = 1.1;

double CountEstimated(const CalibrationCheckOptions& options, const IntrinsicsEntries& held) {
  return IntrinsicsChange::kEntries - (options.higher_prior_sigma == 0 ? kHigherTermsOfLens : 0) -
         static_cast<double>(held.size());
}

// Change of the log at which the windows were linearised, on average.
double MeanAspect(const std::vector<WindowEvidence>& windows, const std::vector<double>& weights) {
  double sum = 0;
  double total_weight = 0;
  for (size_t i = 0; i < windows.size(); ++i) {
    sum += weights[i] * windows[i].aspect;
    total_weight += weights[i];
  }
  return sum / total_weight;
}

// Of what all windows get wrong alike. `linearised_aspect`: where, on average.
IntrinsicsSigmas ModelSigmas(const CalibrationCheckOptions& options, const Vector& change, double linearised_aspect) {
  const double aspect_change = change[IntrinsicsChange::kLogAspect] - linearised_aspect;
  // A lens that distorts much has more to it than the first radial term.
  const double unmodelled =
      options.higher_prior_sigma > 0 ? 0.0 : kHigherTerms * std::abs(change[IntrinsicsChange::kCorrection]);
  return {.focal = std::hypot(options.focal_model_sigma, unmodelled),
          .centre_deg = std::hypot(options.centre_model_sigma_deg, unmodelled * kDegreesPerRadian),
          .correction = std::hypot(options.correction_model_sigma, unmodelled),
          .aspect = std::hypot(options.aspect_model_sigma, kNonlinearAspect * aspect_change),
          .readout = options.readout_model_sigma * change[IntrinsicsChange::kReadout]};
}

}  // namespace

WindowEvidence WithWindowErrors(const CalibrationCheckOptions& options, const Pinhole& given, const Matrix& information,
                                const Vector& weighted_minimum) {
  const Matrix window = CovarianceOf(given, {.focal = options.focal_window_sigma,
                                             .centre_deg = options.centre_window_sigma_deg,
                                             .correction = options.correction_window_sigma});
  // (information^-1 + window)^-1, where information may be singular.
  const Matrix share = (Matrix::Identity() + information * window).inverse();
  return {share * information, share * weighted_minimum};
}

void HoldEntries(const IntrinsicsEntries& entries, const Vector& at, Matrix& information, Vector& vector) {
  for (const IntrinsicsChange::Entry entry : entries) {
    vector -= at[entry] * information.col(entry);
    information.row(entry).setZero();
    information.col(entry).setZero();
    vector[entry] = 0;
  }
}

void HoldHigherTerms(const CalibrationCheckOptions& options, Matrix& information, Vector& vector) {
  if (options.higher_prior_sigma == 0)
    HoldEntries({IntrinsicsChange::kCorrection4, IntrinsicsChange::kCorrection6}, Vector::Zero(), information, vector);
}

double SquaredDistance(const WindowEvidence& window, const Vector& change) {
  const Vector pull = window.weighted_minimum - window.information * change;
  return pull.dot(window.information.ldlt().solve(pull));
}

double MisfitOfDistance(const CalibrationCheckOptions& options, const IntrinsicsEntries& held, double square) {
  return (kStudentDof + CountEstimated(options, held)) * std::log1p(square / kStudentDof);
}

IntrinsicsEstimate CombineWindows(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                  std::vector<WindowEvidence> windows, const IntrinsicsEntries& held) {
  IntrinsicsEstimate estimate{prior.mean, prior.covariance, held};
  if (windows.empty()) return estimate;
  for (WindowEvidence& window : windows) HoldEntries(held, prior.mean, window.information, window.weighted_minimum);
  const Matrix prior_information = prior.covariance.inverse();
  const double entries = CountEstimated(options, held);
  const auto count = static_cast<double>(windows.size());
  std::vector<double> weights(windows.size(), 1.0);
  double scatter = 1;
  for (int round = 0; round < kReweightings; ++round) {
    Matrix information = prior_information;
    Vector weighted = prior_information * prior.mean;
    for (size_t i = 0; i < windows.size(); ++i) {
      information += weights[i] * windows[i].information;
      weighted += weights[i] * windows[i].weighted_minimum;
    }
    estimate.covariance = information.inverse();
    estimate.change = estimate.covariance * weighted;
    double sum = 0;
    for (size_t i = 0; i < windows.size(); ++i) {
      const double square = SquaredDistance(windows[i], estimate.change);
      sum += weights[i] * square;
      // The common minimum follows each window's own: alone, a window says nothing of how far off it is.
      if (count > 1) weights[i] = (kStudentDof + entries) / (kStudentDof + square * count / (count - 1));
    }
    if (count > 1) scatter = std::max(1.0, sum / (entries * (count - 1)));
  }
  estimate.covariance *= scatter;
  estimate.covariance += CovarianceOf(prior.given, ModelSigmas(options, estimate.change, MeanAspect(windows, weights)));
  return estimate;
}

bool MayHaveAspect(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                   const IntrinsicsEstimate& estimate) {
  constexpr int kEntry = IntrinsicsChange::kLogAspect;
  return options.aspect_prior_sigma > 0 && std::abs(estimate.change[kEntry] - prior.mean[kEntry]) <= kMostAspect;
}

IntrinsicsEntries EntriesToHold(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                const std::vector<WindowEvidence>& windows) {
  IntrinsicsEntries held;
  // Whether an entry is off what is expected, by more than `least` and significantly.
  const auto is_off = [&](IntrinsicsChange::Entry entry, double least) {
    const IntrinsicsEstimate estimate = CombineWindows(options, prior, windows, held);
    if (entry == IntrinsicsChange::kLogAspect && !MayHaveAspect(options, prior, estimate)) return false;
    const double off = std::abs(estimate.change[entry] - prior.mean[entry]);
    return off > least && off > options.significance * std::sqrt(estimate.covariance(entry, entry));
  };
  if (!is_off(IntrinsicsChange::kLogAspect, options.min_aspect_error)) held.push_back(IntrinsicsChange::kLogAspect);
  if (!prior.has_readout && !is_off(IntrinsicsChange::kReadout, options.min_readout))
    held.push_back(IntrinsicsChange::kReadout);
  return held;
}

IntrinsicsEstimate EstimateIntrinsics(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                      const std::vector<WindowEvidence>& windows) {
  return CombineWindows(options, prior, windows, EntriesToHold(options, prior, windows));
}

}  // namespace turnscale
