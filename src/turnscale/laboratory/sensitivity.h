// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

/// The scale observer's derivatives at L = 1 m where the car turns by psi (rad) and travels rho/L (31).
ScaleSensitivity SensitivityOfStep(double psi, double travel_ratio);

/// The same as the paper prints them: the one by psi is half of the right one (31).
ScaleSensitivity PrintedSensitivityOfStep(double psi, double travel_ratio);

/// Error of the scale over the scale (32) where psi and theta are both off by `angle_error` (rad).
double ScaleErrorRatio(double psi, double travel_ratio, double angle_error, const ScaleSensitivity& sensitivity);

/// The paper's region of interest (Fig. 7): least and most psi, in degrees, and rho/L.
constexpr std::array<double, 2> kRegionPsi = {3, 5};
constexpr std::array<double, 2> kRegionRatio = {0.2, 0.4};

/// What (32) gives over the region of interest.
struct RegionError {
  double mean = 0;
  double worst = 0;
};
RegionError ErrorOverRegion(double angle_error, bool printed);

}  // namespace turnscale
