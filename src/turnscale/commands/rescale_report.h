// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "turnscale/rescale/rescale.h"

namespace turnscale {

/// scale.csv: a line a pose, its scale from the whole drive, smoothed and filtered.
std::string PoseScaleTable(const RescaleResult& result);

/// turns.csv: a line a turn; cells without a value are empty.
std::string TurnScaleTable(const RescaleResult& result);

/// summary.json: the numbers of the drive, with the unit in each name.
std::string RescaleJson(const RescaleResult& result, const std::string& input);

/// The warning if the turns contradict the estimate, one line; empty where they agree. There has to be an estimate.
std::string RescaleWarning(const RescaleResult& result);

/// A few lines for the screen.
std::string RescaleText(const RescaleResult& result);

/// The drive as SVG: its path from above with the turns, the scale along the path with its band of one sigma and what
/// each turn gives by itself, and the speed that follows (where `timed`). The result has to be observable.
std::string RescaleSvg(const RescaleResult& result, const std::string& title, bool timed);

}  // namespace turnscale
