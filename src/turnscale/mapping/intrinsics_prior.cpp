// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_prior.h"

#include <algorithm>

#include "turnscale/geometry/rotation.h"

namespace turnscale {

Eigen::Vector2d CentreShift(const Pinhole& pinhole, double degrees) {
  const double radians = degrees / kDegreesPerRadian;
  return {pinhole.fx * radians, pinhole.fy * radians};
}

IntrinsicsChange::Matrix CovarianceOf(const Pinhole& given, const IntrinsicsSigmas& sigmas) {
  const Eigen::Vector2d centre = CentreShift(given, sigmas.centre_deg);
  IntrinsicsChange::Vector all;
  all << sigmas.focal, centre.x(), centre.y(), sigmas.correction, sigmas.higher, sigmas.higher, sigmas.aspect,
      sigmas.readout;
  return all.array().square().matrix().asDiagonal();
}

IntrinsicsPrior PriorOf(const CalibrationCheckOptions& options, const Pinhole& given,
                        const IntrinsicsChange::Vector& expected, const std::optional<GivenReadout>& readout) {
  // A sigma of 0 has no inverse.
  constexpr double kLeastReadoutSigma = 1e-5;
  // Terms that are not estimated stay at zero, as nothing refers to them.
  const IntrinsicsSigmas sigmas = {
      .focal = options.focal_prior_sigma,
      .centre_deg = options.centre_prior_sigma_deg,
      .correction = options.correction_prior_sigma,
      .higher = options.higher_prior_sigma > 0 ? options.higher_prior_sigma : 1.0,
      .aspect = options.aspect_prior_sigma > 0 ? options.aspect_prior_sigma : 1.0,
      .readout = readout ? std::max(readout->sigma, kLeastReadoutSigma) : options.readout_prior_sigma};
  IntrinsicsPrior prior{given, expected, CovarianceOf(given, sigmas), readout.has_value()};
  if (readout) prior.mean[IntrinsicsChange::kReadout] = readout->seconds;
  return prior;
}

}  // namespace turnscale
