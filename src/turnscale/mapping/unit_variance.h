// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/mapping/map.h"

namespace turnscale {

/// How accurately the landmarks connect the parts of the map before and after a keyframe: variance of the logarithm of
/// the ratio of their units of length, for independent pixel errors, as a share for one step of the random walk that
/// the unit is along the path.
///
/// A landmark whose rays meet under an angle of a pixels before the keyframe and of b pixels after it determines the
/// ratio with a variance of 2 s^2 (1/a^2 + 1/b^2), as an angle has the errors of two pixels; s^2 is the variance of a
/// pixel, from the reprojection errors. Inverse variances of landmarks add up. Each counts times the number of
/// keyframes that the landmark spans: over all of them the unit changes by its variance once.
///
/// Infinite if no landmark is seen on both sides. Empty for the first keyframe of the map or after a gap, and if fewer
/// than `following` keyframes follow before the next gap: landmarks have too few observations then.
std::optional<double> UnitVariance(const Map& map, int keyframe, int following);

}  // namespace turnscale
