// SPDX-License-Identifier: MIT
#include "turnscale/mapping/calibration_verdict.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/Core>

#include "turnscale/mapping/intrinsics_prior.h"

namespace turnscale {
namespace {

// Relative standard deviation of a focal length beyond which an error of 15 % may go unnoticed.
constexpr double kUndetermined = 0.05;

// Of what the odometry makes the map with.
bool IsOfCamera(const ParameterEstimate& estimate) { return estimate.parameter != IntrinsicsParameter::kReadout; }

// A turn shows little of the aspect.
bool MayLeaveDoubt(const ParameterEstimate& estimate) {
  return IsOfCamera(estimate) && estimate.parameter != IntrinsicsParameter::kPixelAspect;
}

// Whether an error is worth a report, and more than so many standard deviations.
bool Deviates(const CalibrationCheckOptions& options, const Pinhole& given, const ParameterEstimate& estimate,
              double significance) {
  const Eigen::Vector2d centre = CentreShift(given, options.min_centre_error_deg);
  const auto exceeds = [&](double error, double least, double sigma) {
    return error > least && error > significance * sigma;
  };
  const double error = std::abs(estimate.found - estimate.given);
  switch (estimate.parameter) {
    case IntrinsicsParameter::kFocalLength:
      return exceeds(error, given.fx * options.min_focal_error, estimate.sigma);
    case IntrinsicsParameter::kCentreX:
      return exceeds(error, centre.x(), estimate.sigma);
    case IntrinsicsParameter::kCentreY:
      return exceeds(error, centre.y(), estimate.sigma);
    case IntrinsicsParameter::kDistortion:
      return exceeds(error, options.min_correction_error, estimate.sigma);
    case IntrinsicsParameter::kPixelAspect:
      // Of a ratio, twice is as far off as half.
      return exceeds(std::abs(std::log(estimate.found / estimate.given)), options.min_aspect_error,
                     estimate.sigma / estimate.found);
    case IntrinsicsParameter::kReadout:
      return exceeds(error, options.min_readout, estimate.sigma);
  }
  return false;
}

template <typename Predicate>
std::vector<ParameterEstimate> Those(const std::vector<ParameterEstimate>& parameters, const Predicate& predicate) {
  std::vector<ParameterEstimate> those;
  std::ranges::copy_if(parameters, std::back_inserter(those), predicate);
  return those;
}

}  // namespace

bool Contradicts(const CalibrationCheckOptions& options, const Pinhole& given, const ParameterEstimate& estimate) {
  return Deviates(options, given, estimate, options.significance);
}

std::vector<ParameterEstimate> ContradictionsAmong(const CalibrationCheckOptions& options, const Pinhole& given,
                                                   const std::vector<ParameterEstimate>& parameters) {
  return Those(parameters, [&](const ParameterEstimate& estimate) {
    return IsOfCamera(estimate) && Contradicts(options, given, estimate);
  });
}

std::vector<ParameterEstimate> DoubtsAmong(const CalibrationCheckOptions& options, const Pinhole& given,
                                           const std::vector<ParameterEstimate>& parameters) {
  return Those(parameters, [&](const ParameterEstimate& estimate) {
    return MayLeaveDoubt(estimate) && Deviates(options, given, estimate, options.doubt) &&
           !Contradicts(options, given, estimate);
  });
}

bool IsFocalLengthDetermined(const IntrinsicsEstimate& estimate) {
  constexpr int kEntry = IntrinsicsChange::kLogFocal;
  return std::sqrt(estimate.covariance(kEntry, kEntry)) <= kUndetermined;
}

CalibrationVerdict VerdictOn(const CalibrationCheckOptions& options, const Pinhole& given,
                             const std::vector<ParameterEstimate>& parameters, const IntrinsicsEstimate& estimate) {
  if (!ContradictionsAmong(options, given, parameters).empty()) return CalibrationVerdict::kContradicted;
  if (!IsFocalLengthDetermined(estimate)) return CalibrationVerdict::kInDoubt;
  const auto is_off = [&](const ParameterEstimate& parameter) {
    return MayLeaveDoubt(parameter) && std::abs(parameter.found - parameter.given) > options.doubt * parameter.sigma;
  };
  return std::ranges::any_of(parameters, is_off) ? CalibrationVerdict::kInDoubt : CalibrationVerdict::kNotContradicted;
}

}  // namespace turnscale
