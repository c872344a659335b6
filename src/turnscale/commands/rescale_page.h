// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "turnscale/rescale/rescale.h"

namespace turnscale {

/// The page of a rescaled trajectory, HTML. The result has to be observable. `car` is as it was given; `timed`: the
/// poses' times are seconds. `first_time`: from which the page counts, seconds; as TimeOrigin if it is not known.
std::string RescalePage(const RescaleResult& result, const std::string& input, const CarPrior& car, bool timed,
                        std::optional<double> first_time);

}  // namespace turnscale
