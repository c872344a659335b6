// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/pinhole.h"
#include "turnscale/mapping/calibration_check_options.h"
#include "turnscale/mapping/intrinsics_change.h"
#include "turnscale/mapping/intrinsics_estimate.h"
#include "turnscale/mapping/shutter_readout.h"

namespace turnscale {

enum class IntrinsicsParameter { kFocalLength, kCentreX, kCentreY, kDistortion, kPixelAspect, kReadout };

/// One parameter as given and as estimated from the drive: focal length fx and principal point in pixels, the
/// distortion as the radial correction that the calibration lacks, with one term in r^2: the one that is closest to the
/// estimated correction over the image. What counts as given of it is the correction that is applied. The aspect is the
/// width of a pixel over its height, fy / fx. The readout of a rolling shutter is in seconds.
struct ParameterEstimate {
  IntrinsicsParameter parameter = IntrinsicsParameter::kFocalLength;
  double given = 0;
  double found = 0;
  double sigma = 0;
};

/// Focal length, principal point and distortion of the pinhole `given` and of an estimated change of it. `camera`: with
/// the radial correction that is applied.
std::vector<ParameterEstimate> PinholeAndDistortion(const CalibrationCheckOptions& options, const Pinhole& given,
                                                    const CameraModel& camera, const IntrinsicsEstimate& estimate);

/// The pixels' aspect of the same.
ParameterEstimate PixelAspect(const Pinhole& given, const IntrinsicsEstimate& estimate);

/// A readout that is known compared with what windows say without it; sigma is that of the difference. `expected`: mean
/// of the prior of the other entries.
ParameterEstimate ReadoutWithoutPrior(const CalibrationCheckOptions& options, const Pinhole& given,
                                      const IntrinsicsChange::Vector& expected, const GivenReadout& readout,
                                      const std::vector<WindowEvidence>& windows);

}  // namespace turnscale
