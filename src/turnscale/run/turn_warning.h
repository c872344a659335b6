// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>

#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// Why the trajectory uses single-turn scales, in one line; empty where it does not, or where the turns are not the
/// reason. `name_of` names a turn of `estimate.turns`, such as "frames 10-40"; `suspects` is what the user should
/// check. If the turns are consistent without the given camera height, it names the height instead.
std::string TurnWarning(const ScaleEstimate& estimate, const std::function<std::string(int)>& name_of,
                        const std::string& suspects);

/// One line: by how much the given lever arm and camera height disagree, and the value of each that the other one
/// implies. `remedy` is what the user should do.
std::string HeightWarning(const HeightConflict& conflict, double lever_arm, const std::string& remedy);

/// One line: the side slip that the turns show, beside the one that was expected.
std::string SlipWarning(const SlipConflict& conflict);

/// One line: what the turns show of image stabilisation, and what it does to the scale (ScaleEstimate::is_stabilised).
std::string StabilisationWarning(const ScaleEstimate& estimate);

/// One line: by how much the camera's yaw differs from the one that was given or estimated in turns, and what the user
/// should do (`remedy`); or, if it does not differ, that turns and straights show different ones.
std::string YawWarning(const YawConflict& conflict, const std::string& remedy);

}  // namespace turnscale
