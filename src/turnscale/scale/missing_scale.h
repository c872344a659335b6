// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/scale/drive_evidence.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// Why no turn and no height gives a first value of the scale, and what would: one line.
std::string WhyNoStart(const DriveEvidence& evidence, const CarPrior& car, const ScaleEstimatorOptions& options);

/// Why a scale whose smallest sigma (relative) is this one is not claimed, and what would make it known: one line.
std::string WhyTooUncertain(double sigma, const DriveEvidence& evidence, const CarPrior& car,
                            const ScaleEstimatorOptions& options);

}  // namespace turnscale
