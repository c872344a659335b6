// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {

/// What the user should know of the results of a drive, one line each. `summary`: of these frames, which are refined,
/// and this scale; its own warnings do not matter.
std::vector<std::string> RunWarnings(const RunSummary& summary, const std::vector<FrameResult>& frames,
                                     const RefinedScale& scale);

}  // namespace turnscale
