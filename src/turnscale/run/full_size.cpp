// SPDX-License-Identifier: MIT
#include "turnscale/run/full_size.h"

namespace turnscale {

FoundCamera AtFullSize(const ImageScaling& scaling, FoundCamera found) {
  found.camera = scaling.Full(found.camera);
  found.centre_sigma *= scaling.pixel_width();
  return found;
}

ParameterEstimate AtFullSize(const ImageScaling& scaling, ParameterEstimate estimate) {
  switch (estimate.parameter) {
    case IntrinsicsParameter::kFocalLength:
      estimate.given *= scaling.pixel_width();
      estimate.found *= scaling.pixel_width();
      break;
    case IntrinsicsParameter::kCentreX:
    case IntrinsicsParameter::kCentreY:
      estimate.given = scaling.FullPlace(estimate.given);
      estimate.found = scaling.FullPlace(estimate.found);
      break;
    case IntrinsicsParameter::kDistortion:
    case IntrinsicsParameter::kPixelAspect:
    case IntrinsicsParameter::kReadout:
      return estimate;
  }
  estimate.sigma *= scaling.pixel_width();
  return estimate;
}

}  // namespace turnscale
