// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/frames/image_scaling.h"
#include "turnscale/mapping/parameter_estimate.h"
#include "turnscale/odometry/self_calibration.h"

namespace turnscale {

/// What was estimated from scaled images, in pixels of the images at full size.
FoundCamera AtFullSize(const ImageScaling& scaling, FoundCamera found);
ParameterEstimate AtFullSize(const ImageScaling& scaling, ParameterEstimate estimate);

}  // namespace turnscale
