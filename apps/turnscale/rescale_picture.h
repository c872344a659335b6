// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/rescale/rescale.h"

namespace turnscale {

/// The drive as SVG: its path from above with the turns, the scale along the path with its band of one sigma and what
/// each turn says by itself, and the speed that follows (where `timed`). The result has to be observable.
std::string RescaleSvg(const RescaleResult& result, const std::string& title, bool timed);

}  // namespace turnscale
