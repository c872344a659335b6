// SPDX-License-Identifier: MIT
#include "turnscale/mapping/row_direction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "turnscale/bundle/reprojection.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;
using Matrix = IntrinsicsChange::Matrix;

// Earlier windows that are read across at a time: a look is to take little longer than the others.
constexpr size_t kEarlierAtATime = 2;
// After which the rows' direction is not tested any more, if it is clear.
constexpr int kWindowsOfClearDirection = 4;

// Whether windows leave what is expected in doubt, the distortion apart. `along`: their estimate.
bool IsUnexpected(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior, const WindowReadings& readings,
                  const IntrinsicsEstimate& along) {
  const auto is_off = [&](const IntrinsicsEstimate& estimate, IntrinsicsChange::Entry entry) {
    return std::abs(estimate.change[entry] - prior.mean[entry]) >
           options.doubt * std::sqrt(estimate.covariance(entry, entry));
  };
  const IntrinsicsEstimate with_all = CombineWindows(options, prior, EvidenceOf(readings), {});
  return is_off(along, IntrinsicsChange::kLogFocal) || is_off(along, IntrinsicsChange::kCentreX) ||
         is_off(along, IntrinsicsChange::kCentreY) || is_off(with_all, IntrinsicsChange::kLogAspect) ||
         is_off(with_all, IntrinsicsChange::kReadout);
}

// Whether the least readout that is reported would be significant.
bool WouldShowReadout(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                      const WindowReadings& readings) {
  constexpr int kEntry = IntrinsicsChange::kReadout;
  const IntrinsicsEstimate free = CombineWindows(options, prior, EvidenceOf(readings), {IntrinsicsChange::kLogAspect});
  return options.significance * std::sqrt(free.covariance(kEntry, kEntry)) < options.min_readout;
}

// Minus twice the log-likelihood of the change under the prior.
double MisfitOfPrior(const IntrinsicsPrior& prior, const IntrinsicsEstimate& estimate) {
  const Vector off = estimate.change - prior.mean;
  return off.dot(prior.covariance.inverse() * off);
}

// The same of what the window has left, but for the residuals. `pixel_sigma`: in whose units, pixels.
double MisfitOfWindow(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                      const WindowReading& reading, const IntrinsicsEstimate& estimate, double pixel_sigma) {
  const double rescale = std::pow(reading.pixel_sigma / pixel_sigma, 2);
  Matrix information = rescale * reading.own_information;
  Vector gradient = rescale * reading.own_gradient;
  WindowEvidence evidence = WithWindowErrors(options, prior.given, information, information * reading.at - gradient);
  HoldEntries(estimate.held, prior.mean, evidence.information, evidence.weighted_minimum);
  const double square = SquaredDistance(evidence, estimate.change);
  // How far the cost is from that of the window's own minimum, where entries that are held are as expected.
  Vector to_held = Vector::Zero();
  for (const IntrinsicsChange::Entry entry : estimate.held) to_held[entry] = prior.mean[entry] - reading.at[entry];
  const double gained = -to_held.dot(2 * gradient + information * to_held);
  HoldEntries(estimate.held, -to_held, information, gradient);
  const double left = gained + gradient.dot(information.ldlt().solve(gradient));
  return MisfitOfDistance(options, estimate.held, square) - left;
}

// The same of the residuals of one reading less those of another.
double ResidualsBeyond(const CalibrationCheckOptions& options, const WindowReading& reading, const WindowReading& other,
                       double pixel_sigma) {
  const std::vector<double>& ones = *reading.residuals;
  const std::vector<double>& others = *other.residuals;
  const auto cost = [&](double residual) {
    return HuberCost(std::pow(residual / pixel_sigma, 2), options.huber_threshold);
  };
  double difference = 0;
  for (size_t i = 0; i < std::min(ones.size(), others.size()); ++i)
    if (std::isfinite(ones[i] + others[i])) difference += cost(ones[i]) - cost(others[i]);
  return 2 * Deflation(options) * difference;
}

}  // namespace

void RowDirectionChoice::Update(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                const WindowReadings& along) {
  // Without the aspect, its part of the error is taken for something else.
  if (options.aspect_prior_sigma == 0 || is_clearly_along_) return;
  const IntrinsicsEstimate estimate = EstimateIntrinsics(options, prior, EvidenceOf(along));
  if (across_.empty() && !IsUnexpected(options, prior, along, estimate)) return;
  // They stay beside one another, of the same windows.
  if (!ReadAcross(options, prior, estimate, ReadingPlace::kLast, *along.back().window)) {
    // Beginning anew with the next window that is unexpected.
    across_.clear();
    reads_earlier_ = false;
    direction_ = RowDirection::kAlong;
    return;
  }
  for (size_t read = 0; read < kEarlierAtATime && reads_earlier_ && across_.size() < along.size(); ++read) {
    const WindowReading& earlier = along[along.size() - 1 - across_.size()];
    reads_earlier_ = earlier.window && ReadAcross(options, prior, estimate, ReadingPlace::kFirst, *earlier.window);
  }
  Compare(options, prior, along);
}

// `along`: the estimate from windows that were read as in the camera. False where the window determines nothing.
bool RowDirectionChoice::ReadAcross(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                    const IntrinsicsEstimate& along, ReadingPlace place,
                                    const IntrinsicsProblem& window) {
  IntrinsicsProblem turned = window;
  turned.ReadAcross();
  const IntrinsicsEstimate known = EstimateIntrinsics(options, prior, EvidenceOf(across_));
  Vector start = across_.empty() ? along.change : known.change;
  for (const IntrinsicsChange::Entry entry : known.held) start[entry] = prior.mean[entry];
  turned.Change(start);
  return AddReading(options, prior, known, place, turned, across_);
}

// Sets the direction to what is likely with the windows that were read in both.
void RowDirectionChoice::Compare(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior,
                                 const WindowReadings& along) {
  const WindowReadings beside(along.end() - static_cast<std::ptrdiff_t>(across_.size()), along.end());
  const IntrinsicsEstimate estimate_along = EstimateIntrinsics(options, prior, EvidenceOf(beside));
  const IntrinsicsEstimate estimate_across = EstimateIntrinsics(options, prior, EvidenceOf(across_));
  double gain = MisfitOfPrior(prior, estimate_along) - MisfitOfPrior(prior, estimate_across);
  int compared = 0;
  for (size_t i = 0; i < across_.size(); ++i) {
    if (!beside[i].residuals || !across_[i].residuals) continue;
    const double sigma = std::min(beside[i].pixel_sigma, across_[i].pixel_sigma);
    gain += MisfitOfWindow(options, prior, beside[i], estimate_along, sigma) -
            MisfitOfWindow(options, prior, across_[i], estimate_across, sigma) +
            ResidualsBeyond(options, beside[i], across_[i], sigma);
    ++compared;
  }
  const double clear = options.significance * options.significance;
  const bool has_none = estimate_across.Holds(IntrinsicsChange::kReadout);
  const bool is_along = has_none || gain <= -clear;
  direction_ = is_along ? RowDirection::kAlong : gain > clear ? RowDirection::kAcross : RowDirection::kOpen;
  is_clearly_along_ =
      compared >= kWindowsOfClearDirection && (has_none ? WouldShowReadout(options, prior, across_) : is_along);
  if (is_clearly_along_) across_.clear();
}

}  // namespace turnscale
