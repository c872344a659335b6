// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/laboratory/scale_drive.h"

namespace turnscale {

/// What a visual odometry makes of a synthetic drive: bundle adjustment of all keyframes and landmarks, the first
/// keyframe fixed. The pixels hold the unit of length together along the drive, but do not say what it is. Throws
/// NumericalError where the adjustment does not converge.
Map PointOdometry(const ScaleDrive& drive);

/// The same map as an odometry would give it whose unit shrinks by `loss` every so many frames; landmarks go with the
/// keyframe that saw them from closest by.
void LoseScale(double loss, int frames, Map& map);

}  // namespace turnscale
