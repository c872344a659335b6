// SPDX-License-Identifier: MIT
#include "turnscale/mapping/parameter_estimate.h"

#include <cmath>
#include <optional>

#include "turnscale/mapping/intrinsics_prior.h"

namespace turnscale {
namespace {

using Vector = IntrinsicsChange::Vector;

// Radius of the image's corner on the plane z = 1.
double CornerRadius(const Pinhole& pinhole) { return std::hypot(pinhole.cx / pinhole.fx, pinhole.cy / pinhole.fy); }

// The correction in r^2 alone that moves the pixels of a disc most alike, by its weights in r^2, r^4 and r^6: least
// squares of the shift c r^3 over the disc. Its radius is that of the image's corner on the plane z = 1.
Vector WeightsOfDistortion(const CalibrationCheckOptions& options, const Pinhole& pinhole) {
  const double corner = CornerRadius(pinhole);
  Vector weights = Vector::Zero();
  weights[IntrinsicsChange::kCorrection] = 1;
  if (options.higher_prior_sigma == 0) return weights;
  weights[IntrinsicsChange::kCorrection4] = 8.0 / 10 * std::pow(corner, 2);
  weights[IntrinsicsChange::kCorrection6] = 8.0 / 12 * std::pow(corner, 4);
  return weights;
}

// The same of the correction that is applied. CorrectRadially takes the radius without the lens's distortion.
double AppliedCorrection(const CameraModel& camera) {
  constexpr int kRadii = 64;
  if (camera.radial_correction == 0) return 0;
  const double corner = CornerRadius(camera.pinhole);
  double sum = 0;
  double weights = 0;
  for (int i = 0; i < kRadii; ++i) {
    const double radius = corner * (i + 0.5) / kRadii;
    const std::optional<UndistortedPoint> ideal = UndistortPoint(camera, {radius, 0});
    if (!ideal) break;
    sum += camera.radial_correction * ideal->point.squaredNorm() * std::pow(radius, 5);
    weights += std::pow(radius, 7);
  }
  return weights > 0 ? sum / weights : camera.radial_correction;
}

}  // namespace

std::vector<ParameterEstimate> PinholeAndDistortion(const CalibrationCheckOptions& options, const Pinhole& given,
                                                    const CameraModel& camera, const IntrinsicsEstimate& estimate) {
  const Vector sigmas = estimate.covariance.diagonal().cwiseSqrt();
  const Pinhole found = ChangedPinhole(given, estimate.change);
  const Vector distortion = WeightsOfDistortion(options, given);
  return {{IntrinsicsParameter::kFocalLength, given.fx, found.fx, sigmas[IntrinsicsChange::kLogFocal] * found.fx},
          {IntrinsicsParameter::kCentreX, given.cx, found.cx, sigmas[IntrinsicsChange::kCentreX]},
          {IntrinsicsParameter::kCentreY, given.cy, found.cy, sigmas[IntrinsicsChange::kCentreY]},
          {IntrinsicsParameter::kDistortion, AppliedCorrection(camera), distortion.dot(estimate.change),
           std::sqrt(distortion.dot(estimate.covariance * distortion))}};
}

ParameterEstimate PixelAspect(const Pinhole& given, const IntrinsicsEstimate& estimate) {
  constexpr int kEntry = IntrinsicsChange::kLogAspect;
  const double aspect = given.fy / given.fx;
  const double found = aspect * std::exp(estimate.change[kEntry]);
  return {IntrinsicsParameter::kPixelAspect, aspect, found, found * std::sqrt(estimate.covariance(kEntry, kEntry))};
}

ParameterEstimate ReadoutWithoutPrior(const CalibrationCheckOptions& options, const Pinhole& given,
                                      const Vector& expected, const GivenReadout& readout,
                                      const std::vector<WindowEvidence>& windows) {
  constexpr int kEntry = IntrinsicsChange::kReadout;
  // As wide as what is given, so that the prior alone contradicts nothing.
  CalibrationCheckOptions wide = options;
  wide.readout_prior_sigma = std::hypot(options.readout_prior_sigma, readout.seconds);
  const IntrinsicsPrior prior = PriorOf(wide, given, expected, std::nullopt);
  IntrinsicsEntries held = EntriesToHold(options, prior, windows);
  std::erase(held, IntrinsicsChange::kReadout);
  const IntrinsicsEstimate alone = CombineWindows(options, prior, windows, held);
  return {IntrinsicsParameter::kReadout, readout.seconds, alone.change[kEntry],
          std::hypot(readout.sigma, std::sqrt(alone.covariance(kEntry, kEntry)))};
}

}  // namespace turnscale
