// SPDX-License-Identifier: MIT
#include "turnscale/mapping/window_reading.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;
using Matrix = IntrinsicsChange::Matrix;

constexpr int kIterationsAtFirst = 10;
constexpr int kIterationsAfterAStep = 5;
// A step below this many standard deviations changes nothing that is reported.
constexpr double kSmallStep = 0.3;
// Farther than this at once the linear model is not to be trusted: log of the focal length, principal point in focal
// lengths, correction.
constexpr double kLongestFocalStep = 0.1;
constexpr double kLongestCentreStep = 0.05;
constexpr double kLongestCorrectionStep = 0.04;
constexpr double kLongestHigherStep = 0.04;
constexpr double kLongestAspectStep = 0.1;  // log
// The latest windows, half a megabyte each, can be linearised again.
constexpr size_t kKeptWindows = 12;

// Share of a step that stays within what the linear model is good for.
double ShareOf(const Vector& step, const Pinhole& pinhole) {
  const double higher =
      std::max(std::abs(step[IntrinsicsChange::kCorrection4]), std::abs(step[IntrinsicsChange::kCorrection6]));
  const double longest =
      std::max({std::abs(step[IntrinsicsChange::kLogFocal]) / kLongestFocalStep,
                std::abs(step[IntrinsicsChange::kCentreX]) / (kLongestCentreStep * pinhole.fx),
                std::abs(step[IntrinsicsChange::kCentreY]) / (kLongestCentreStep * pinhole.fy),
                std::abs(step[IntrinsicsChange::kCorrection]) / kLongestCorrectionStep, higher / kLongestHigherStep,
                std::abs(step[IntrinsicsChange::kLogAspect]) / kLongestAspectStep});
  return 1.0 / std::max(1.0, longest);
}

WindowReading ReadingAt(const CalibrationCheckOptions& options, const Pinhole& given,
                        const IntrinsicsEvidence& evidence, const IntrinsicsProblem& window) {
  const double deflation = Deflation(options);
  WindowReading reading;
  reading.evidence =
      WithWindowErrors(options, given, deflation * evidence.information, deflation * evidence.weighted_minimum());
  reading.evidence.aspect = evidence.at[IntrinsicsChange::kLogAspect];
  reading.pixel_sigma = evidence.pixel_sigma;
  reading.at = evidence.at;
  reading.own_information = deflation * evidence.information;
  reading.own_gradient = deflation * evidence.gradient;
  reading.residuals = std::make_shared<const std::vector<double>>(window.Residuals());
  return reading;
}

// Reads the windows that are kept again, one after another, with what the readings of all let free.
void Relinearise(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior, WindowReadings& readings) {
  const IntrinsicsEntries held = EntriesToHold(options, prior, EvidenceOf(readings));
  WindowReadings before = std::exchange(readings, {});
  for (WindowReading& reading : before) {
    if (reading.window) {
      IntrinsicsProblem window = *reading.window;
      const IntrinsicsEstimate known = CombineWindows(options, prior, EvidenceOf(readings), held);
      if (!readings.empty()) window.Change(known.change);
      if (std::optional<WindowReading> again = ReadWindow(options, prior.given, known, window)) {
        again->window = reading.window;
        reading = std::move(*again);
      }
    }
    readings.push_back(std::move(reading));
  }
}

}  // namespace

std::vector<WindowEvidence> EvidenceOf(const WindowReadings& readings) {
  std::vector<WindowEvidence> evidence;
  evidence.reserve(readings.size());
  for (const WindowReading& reading : readings) evidence.push_back(reading.evidence);
  return evidence;
}

double Deflation(const CalibrationCheckOptions& options) {
  return 1.0 / (options.pixel_sigma_inflation * options.pixel_sigma_inflation);
}

std::optional<WindowReading> ReadWindow(const CalibrationCheckOptions& options, const Pinhole& given,
                                        const IntrinsicsEstimate& known, IntrinsicsProblem& window) {
  const Matrix known_information = known.covariance.inverse();
  const double deflation = Deflation(options);
  for (int round = 1;; ++round) {
    if (!window.Adjust(round == 1 ? kIterationsAtFirst : kIterationsAfterAStep)) return std::nullopt;
    window.EstimatePixelSigma();
    std::optional<IntrinsicsEvidence> evidence = window.Evidence();
    if (!evidence) return std::nullopt;
    HoldHigherTerms(options, evidence->information, evidence->gradient);
    Matrix information = deflation * evidence->information;
    Vector gradient = deflation * evidence->gradient;
    HoldEntries(known.held, Vector::Zero(), information, gradient);
    const Matrix total = information + known_information;
    const Vector slope = gradient + known_information * (evidence->at - known.change);
    const Vector step = -total.ldlt().solve(slope);
    if (!step.allFinite()) return std::nullopt;
    if (round == options.max_rounds || step.dot(total * step) < kSmallStep * kSmallStep)
      return ReadingAt(options, given, *evidence, window);
    window.Follow(*evidence, evidence->at + ShareOf(step, given) * step);
  }
}

bool AddReading(const CalibrationCheckOptions& options, const IntrinsicsPrior& prior, const IntrinsicsEstimate& known,
                ReadingPlace place, IntrinsicsProblem& window, WindowReadings& readings) {
  std::optional<WindowReading> reading = ReadWindow(options, prior.given, known, window);
  if (!reading) return false;
  reading->window = std::make_shared<const IntrinsicsProblem>(window);
  readings.insert(place == ReadingPlace::kFirst ? readings.begin() : readings.end(), std::move(*reading));
  if (readings.size() > kKeptWindows) {
    WindowReading& earlier = readings[readings.size() - 1 - kKeptWindows];
    earlier.window.reset();
    earlier.residuals.reset();
  }
  const bool frees_aspect =
      known.Holds(IntrinsicsChange::kLogAspect) &&
      !EstimateIntrinsics(options, prior, EvidenceOf(readings)).Holds(IntrinsicsChange::kLogAspect);
  if (frees_aspect) Relinearise(options, prior, readings);
  return true;
}

}  // namespace turnscale
