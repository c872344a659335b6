// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/rescale/rescale.h"

namespace turnscale {

/// The page of a rescaled trajectory, HTML. The result has to be observable. `lever_arm` in metres; `timed`: the poses'
/// times are seconds.
std::string RescalePage(const RescaleResult& result, const std::string& input, double lever_arm, bool timed);

}  // namespace turnscale
