// SPDX-License-Identifier: MIT
#include "turnscale/mapping/calibration_check.h"

#include <algorithm>
#include <cmath>

#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/local_bundle_adjustment.h"

namespace turnscale {
namespace {

// From one look to the next, at most, in halves of a window.
constexpr int kLongestInterval = 8;

// Largest angle between the first or the last of the keyframes and another, radians.
double LargestTurn(const Map& map, int first, int last) {
  double largest = 0;
  for (int k = first; k <= last; ++k)
    for (const int end : {first, last}) largest = std::max(largest, TurnBetween(map, end, k));
  return largest;
}

}  // namespace

CalibrationCheck::CalibrationCheck(const CalibrationCheckOptions& options, const Pinhole& given,
                                   const IntrinsicsChange::Vector& expected, const std::optional<GivenReadout>& readout)
    : options_(options),
      given_(given),
      expected_(expected),
      given_readout_(readout),
      next_keyframe_(options.window - 1) {}

std::optional<IntrinsicsProblem> CalibrationCheck::TakeWindow(const Map& map) {
  const int latest = CountKeyframes(map) - 1;
  if (!options_.enabled || IsComplete() || latest < next_keyframe_) return std::nullopt;
  const int first = StartOfMap(map, std::max(0, latest - options_.window + 1));
  if (InDegrees(LargestTurn(map, first, latest)) < options_.min_turn_deg) return std::nullopt;
  // What windows have in common is known soon: later ones come less often, and only the first overlap.
  next_keyframe_ = latest + std::min(windows() + 1, kLongestInterval) * (options_.window / 2);
  IntrinsicsWindow window;
  window.first = first;
  window.last = latest;
  window.max_landmarks = options_.max_landmarks;
  window.huber_threshold = options_.huber_threshold;
  IntrinsicsProblem problem(map, map.camera, window, options_.pixel_sigma);
  if (problem.landmarks() == 0) return std::nullopt;
  return problem;
}

bool CalibrationCheck::Read(IntrinsicsProblem& window) {
  const IntrinsicsPrior prior = Prior();
  const IntrinsicsEstimate known = EstimateIntrinsics(options_, prior, EvidenceOf(along_));
  // The first window begins with the correction that is applied.
  if (!along_.empty()) window.Change(known.change);
  if (!AddReading(options_, prior, known, ReadingPlace::kLast, window, along_)) return false;
  observed_radius_ = std::max(observed_radius_, window.ObservedRadius());
  read_direction_ = window.read_direction();
  if (given_readout_)
    is_readout_contradicted_ = Contradicts(options_, given_, KnownReadout());
  else
    direction_.Update(options_, prior, along_);
  return true;
}

bool CalibrationCheck::Observe(const Map& map) {
  std::optional<IntrinsicsProblem> window = TakeWindow(map);
  return window && Read(*window);
}

IntrinsicsPrior CalibrationCheck::Prior() const {
  return PriorOf(options_, given_, expected_, is_readout_contradicted_ ? std::nullopt : given_readout_);
}

IntrinsicsEstimate CalibrationCheck::WithOpenDirection(
    const std::function<IntrinsicsEstimate(const std::vector<WindowEvidence>&)>& estimate) const {
  IntrinsicsEstimate result = estimate(Evidence());
  if (!IsDirectionOpen()) return result;
  const IntrinsicsEstimate across = estimate(EvidenceOf(direction_.across()));
  IntrinsicsChange::Vector difference = result.change - across.change;
  difference[IntrinsicsChange::kReadout] = 0;
  result.covariance += difference.array().square().matrix().asDiagonal();
  return result;
}

IntrinsicsEstimate CalibrationCheck::Estimate() const {
  return WithOpenDirection(
      [&](const std::vector<WindowEvidence>& windows) { return EstimateIntrinsics(options_, Prior(), windows); });
}

ParameterEstimate CalibrationCheck::KnownReadout() const {
  return ReadoutWithoutPrior(options_, given_, expected_, *given_readout_, Evidence());
}

std::vector<ParameterEstimate> CalibrationCheck::Parameters(const CameraModel& camera) const {
  const IntrinsicsPrior prior = Prior();
  const IntrinsicsEstimate estimate = Estimate();
  std::vector<ParameterEstimate> parameters = PinholeAndDistortion(options_, given_, camera, estimate);
  // Where the estimate holds the aspect, its error is that of an estimate which does not.
  if (!estimate.Holds(IntrinsicsChange::kLogAspect)) {
    parameters.push_back(PixelAspect(given_, estimate));
  } else {
    const IntrinsicsEstimate with_aspect = WithOpenDirection(
        [&](const std::vector<WindowEvidence>& windows) { return CombineWindows(options_, prior, windows, {}); });
    if (MayHaveAspect(options_, prior, with_aspect)) parameters.push_back(PixelAspect(given_, with_aspect));
  }
  if (given_readout_) parameters.push_back(KnownReadout());
  return parameters;
}

std::vector<ParameterEstimate> CalibrationCheck::Contradictions(const CameraModel& camera) const {
  if (along_.empty()) return {};
  return ContradictionsAmong(options_, given_, Parameters(camera));
}

std::vector<ParameterEstimate> CalibrationCheck::Doubts(const CameraModel& camera) const {
  if (along_.empty()) return {};
  return DoubtsAmong(options_, given_, Parameters(camera));
}

CalibrationVerdict CalibrationCheck::Verdict(const CameraModel& camera) const {
  if (along_.empty()) return CalibrationVerdict::kNotContradicted;
  return VerdictOn(options_, given_, Parameters(camera), Estimate());
}

std::optional<ParameterEstimate> CalibrationCheck::ContradictedReadout(const CameraModel& camera) const {
  if (!is_readout_contradicted_ || !Contradictions(camera).empty()) return std::nullopt;
  return KnownReadout();
}

std::optional<ShutterReadout> CalibrationCheck::Readout(const CameraModel& camera) const {
  if (along_.empty() || !Contradictions(camera).empty()) {
    if (!given_readout_ || given_readout_->seconds == 0) return std::nullopt;
    return ShutterReadout{given_readout_->seconds, given_readout_->sigma, camera.read_direction};
  }
  return LatestReadout();
}

std::optional<ShutterReadout> CalibrationCheck::LatestReadout() const {
  constexpr int kEntry = IntrinsicsChange::kReadout;
  if (along_.empty() || IsDirectionOpen()) return std::nullopt;
  const bool is_known = given_readout_ && !is_readout_contradicted_;
  if (is_known && given_readout_->seconds == 0) return std::nullopt;
  const IntrinsicsEstimate estimate = Estimate();
  if (estimate.Holds(IntrinsicsChange::kReadout)) return std::nullopt;
  const double seconds = estimate.change[kEntry];
  double sigma = std::sqrt(estimate.covariance(kEntry, kEntry));
  // What windows get wrong alike does not make it less certain than it was.
  if (is_known) sigma = std::min(sigma, given_readout_->sigma);
  if (!IsReadAcross()) return ShutterReadout{seconds, sigma, read_direction_};
  // No row is stored as the first one.
  const ReadDirection across = Across(read_direction_);
  const int sign = seconds < 0 ? -1 : 1;
  return ShutterReadout{std::abs(seconds), sigma, {sign * across.x, sign * across.y}};
}

}  // namespace turnscale
