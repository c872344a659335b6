// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/geometry/pinhole.h"
#include "turnscale/mapping/calibration_check_options.h"
#include "turnscale/mapping/intrinsics_estimate.h"
#include "turnscale/mapping/parameter_estimate.h"

namespace turnscale {

/// How a calibration has passed its test.
enum class CalibrationVerdict { kNotContradicted, kInDoubt, kContradicted };

// Thresholds in pixels are angles at the pinhole `given`.

/// Whether the error of a parameter is worth a report, and significant.
bool Contradicts(const CalibrationCheckOptions& options, const Pinhole& given, const ParameterEstimate& estimate);

/// Those inconsistent with the camera that the map is made with: the readout apart, which is corrected afterwards.
std::vector<ParameterEstimate> ContradictionsAmong(const CalibrationCheckOptions& options, const Pinhole& given,
                                                   const std::vector<ParameterEstimate>& parameters);

/// Those of focal length, principal point and distortion whose error is worth a report too, but exceeds only `doubt`
/// standard deviations.
std::vector<ParameterEstimate> DoubtsAmong(const CalibrationCheckOptions& options, const Pinhole& given,
                                           const std::vector<ParameterEstimate>& parameters);

/// Whether an error of the focal length that would bias the scale by tens of per cent would be noticed.
bool IsFocalLengthDetermined(const IntrinsicsEstimate& estimate);

/// Contradicted by a parameter. In doubt if the focal length is not determined, or it, the principal point or the
/// distortion deviates by more than `doubt` standard deviations, however little that is.
CalibrationVerdict VerdictOn(const CalibrationCheckOptions& options, const Pinhole& given,
                             const std::vector<ParameterEstimate>& parameters, const IntrinsicsEstimate& estimate);

}  // namespace turnscale
