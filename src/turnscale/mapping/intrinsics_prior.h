// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/mapping/calibration_check_options.h"
#include "turnscale/mapping/intrinsics_change.h"
#include "turnscale/mapping/shutter_readout.h"

namespace turnscale {

/// Standard deviations of intrinsics in the units of the options, which do not depend on the camera.
struct IntrinsicsSigmas {
  double focal = 0;       ///< relative
  double centre_deg = 0;  ///< principal point, as an angle at the camera, degrees
  double correction = 0;  ///< radial correction in r^2
  double higher = 0;      ///< its terms in r^4 and r^6
  double aspect = 0;      ///< relative
  double readout = 0;     ///< seconds
};

/// Shift of the principal point by a small angle at the camera, pixels along x and y.
Eigen::Vector2d CentreShift(const Pinhole& pinhole, double degrees);

/// Covariance of a change of the pinhole `given`: diagonal.
IntrinsicsChange::Matrix CovarianceOf(const Pinhole& given, const IntrinsicsSigmas& sigmas);

/// What is known of the intrinsics without the images of turns.
struct IntrinsicsPrior {
  Pinhole given;  ///< that changes count from
  IntrinsicsChange::Vector mean = IntrinsicsChange::Vector::Zero();
  IntrinsicsChange::Matrix covariance = IntrinsicsChange::Matrix::Identity();
  bool has_readout = false;  ///< one that is known; otherwise a global shutter is expected
};

/// The prior of the options, with `expected` as its mean, but for a readout that is known.
IntrinsicsPrior PriorOf(const CalibrationCheckOptions& options, const Pinhole& given,
                        const IntrinsicsChange::Vector& expected, const std::optional<GivenReadout>& readout);

}  // namespace turnscale
