// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/results.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {

/// Times, seconds, from which on the images show another view than just before, so that the map began anew: tracking
/// was good until then, and the next map began as soon as the last was given up. Videos that were cut or joined look
/// so, and recorders that skip images without a word. `frames`: of the drive, refined, in the order of their numbers.
/// `seams`: when clips begin that follow others, seconds; nothing is said of them.
std::vector<double> FindViewChanges(const std::vector<FrameResult>& frames, const std::vector<MapRestart>& restarts,
                                    const std::vector<double>& seams = {});

/// The warning, one line, with times counted from `first_time`; empty if there are none.
std::string ViewChangeText(const std::vector<double>& times, double first_time);

}  // namespace turnscale
