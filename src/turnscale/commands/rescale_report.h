// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/rescale/rescale.h"

namespace turnscale {

/// scale.csv: a line a pose, its scale from the whole drive, smoothed and filtered.
std::string PoseScaleTable(const RescaleResult& result);

/// turns.csv: a line a turn; cells without a value are empty.
std::string TurnScaleTable(const RescaleResult& result);

/// summary.json: the numbers of the drive, with the unit in each name, and the warnings of the command.
std::string RescaleJson(const RescaleResult& result, const std::string& input, bool timed,
                        const std::vector<std::string>& warnings);

/// Of turns that contradict the estimate, and of a lever arm and a camera height that disagree: a line each. There has
/// to be an estimate. `car` is as it was given.
std::vector<std::string> RescaleWarnings(const RescaleResult& result, const CarPrior& car);

/// A few lines for the screen.
std::string RescaleText(const RescaleResult& result);

/// The drive as SVG: its path from above with the turns, the scale along the path with its band of one sigma and what
/// each turn gives by itself, and the speed that follows (where `timed`). The result has to be observable.
std::string RescaleSvg(const RescaleResult& result, const std::string& title, bool timed);

}  // namespace turnscale
