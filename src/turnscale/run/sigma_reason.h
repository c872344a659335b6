// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/drive_facts.h"
#include "turnscale/run/path_summary.h"
#include "turnscale/run/scale_summary.h"

namespace turnscale {

/// Relative standard deviation of a path in metres above which the summary says why it is so large.
inline constexpr double kExplainedSigma = 0.1;

/// Why a sigma of the scale, that of the path's length or the largest along the drive, is above kExplainedSigma: what
/// contributes most to it, one line. Empty where none is, or the scale is pending. `frames`: refined, with this scale;
/// `summary`: its sigmas and number of turns.
std::string SigmaReason(const DriveFacts& drive, const std::vector<FrameResult>& frames, const RefinedScale& scale,
                        const PathSummary& path, const ScaleSummary& summary);

}  // namespace turnscale
