// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// Moves a pixel away from the principal point (towards it where `correction` < 0) by the share correction * r^2, r
/// being its distance from the principal point in focal lengths: what a calibration has left of the lens's distortion.
Eigen::Vector2d CorrectRadially(const Pinhole& pinhole, double correction, const Eigen::Vector2d& pixel);

/// The pixel that CorrectRadially moves to this one. Exact to rounding for corrections of a few per cent.
Eigen::Vector2d UndoRadialCorrection(const Pinhole& pinhole, double correction, const Eigen::Vector2d& pixel);

}  // namespace turnscale
