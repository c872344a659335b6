// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/mapping/map.h"

namespace turnscale {

/// How well the landmarks carry the map's unit of length past a keyframe: variance of the logarithm of the unit after
/// it to that before it, as a share for one step of the random walk that it is along the path.
///
/// A landmark whose rays meet under an angle of a pixels before the keyframe and of b pixels after it is as deep as
/// either side says to s/a and s/b (relative standard deviations; s: of a pixel, from the reprojection errors), so that
/// it tells the ratio of the units to hypot(s/a, s/b). Few landmarks, or far ones only, carry it badly: on bare streets
/// the unit changes by tens of per cent within a map without a gap. Errors that all pixels of a landmark share are not
/// included. Infinite where no landmark is seen from both sides; empty for the first keyframe of the map, or
/// after a gap. Means little while few keyframes follow.
std::optional<double> UnitVariance(const Map& map, int keyframe);

}  // namespace turnscale
