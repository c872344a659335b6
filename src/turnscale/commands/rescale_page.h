// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/rescale/rescale.h"

namespace turnscale {

/// The page of a rescaled trajectory, HTML. The result has to be observable. `car` is as it was given; `timed`: the
/// poses' times are seconds.
std::string RescalePage(const RescaleResult& result, const std::string& input, const CarPrior& car, bool timed);

}  // namespace turnscale
