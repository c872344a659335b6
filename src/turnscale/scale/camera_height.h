// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// Typical height of a car's camera above the road, metres, and the relative standard deviation of such heights: 19 of
/// 20 are between 0.85 m (sports cars) and 2.3 m (vans).
inline constexpr double kUsualHeight = 1.4;
inline constexpr double kUsualHeightSpread = 0.25;

/// The height of the camera above the road by the scale of the trajectory, metres: where single-turn scales are used,
/// by these. 0 if it is not known.
double HeightByScale(const ScaleEstimate& estimate);

/// Standard deviation of HeightByScale, metres, with what the sigma of the scale has for contradictions: the height is
/// off by what the scale is off by. `other_sigma`: of the scale for other reasons, such as the calibration, relative.
/// Single-turn scales contribute what they differ by.
double HeightSigma(const ScaleEstimate& estimate, double other_sigma = 0);

/// An estimated height of the camera above the road that is unusual for a car. It is proportional to the scale, so that
/// a wrong lever arm shows in it, and images that stabilisation turns with a delay (too low).
struct UnusualHeight {
  double height = 0;       ///< metres
  double sigma = 0;        ///< metres
  double scale_error = 0;  ///< of the scale, as a logarithm, if the true height is kUsualHeight; not negative
  bool is_low = false;     ///< rather than high
};

/// Nothing for a height within two standard deviations of the typical one, its own and that of such heights together,
/// and for 0: not known.
std::optional<UnusualHeight> FindUnusualHeight(double height, double sigma);

}  // namespace turnscale
