// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// By how much a camera differs from a given one: log of the focal length's ratio (both axes together), principal point
/// x and y (pixels, further right and down), the terms in r^2, r^4 and r^6 of the radial correction (Correct): the
/// whole of it, not what comes on top of the one that is applied to the map's pixels; log of the ratio of fy / fx, the
/// width of a pixel over its height; and the seconds in which a rolling shutter reads the rows, from the top to the
/// bottom of the image (below 0: from the bottom to the top), where 0 is given.
struct IntrinsicsChange {
  enum Entry { kLogFocal, kCentreX, kCentreY, kCorrection, kCorrection4, kCorrection6, kLogAspect, kReadout };
  static constexpr int kEntries = kReadout + 1;
  static constexpr int kCorrectionTerms = 3;
  using Vector = Eigen::Matrix<double, kEntries, 1>;
  using Matrix = Eigen::Matrix<double, kEntries, kEntries>;
};

/// The pinhole that differs by `change` from `given`. Correction and readout play no part.
Pinhole ChangedPinhole(const Pinhole& given, const IntrinsicsChange::Vector& change);

/// Where the ideal pinhole camera shows the ray of a distorted pixel, and the derivative of the ray by the distorted
/// point (both on the plane z = 1).
struct CorrectedPixel {
  Eigen::Vector2d pixel;
  Eigen::Vector2d lens_point;  ///< without distortion as `camera` has it, before the correction
  Eigen::Matrix2d jacobian;
};

/// Undistorts a pixel with the lens of `camera`, the pinhole that differs by `change` from its own, and the correction
/// of `change`: on the plane z = 1, the ray moves away from the axis by the share kCorrection r^2 + kCorrection4 r^4 +
/// kCorrection6 r^6, r being the distance of the distorted point from the axis, which is bounded for any lens.
/// `camera.radial_correction` and the readout play no part. Nothing where the lens has no ray for the pixel.
std::optional<CorrectedPixel> Correct(const CameraModel& camera, const IntrinsicsChange::Vector& change,
                                      const Eigen::Vector2d& distorted);

/// Derivative of (predicted pixel - corrected pixel) by the intrinsics, pixels per unit of each. `pinhole` is that of
/// the prediction, `distorted` the point on the plane z = 1 that was corrected, `row_motion` how far the predicted
/// pixel moves while its row waits, pixels per second of readout.
Eigen::Matrix<double, 2, IntrinsicsChange::kEntries> IntrinsicsJacobian(const Pinhole& pinhole,
                                                                        const Eigen::Vector3d& x_in_camera,
                                                                        const Eigen::Vector2d& distorted,
                                                                        const CorrectedPixel& corrected,
                                                                        const Eigen::Vector2d& row_motion);

}  // namespace turnscale
