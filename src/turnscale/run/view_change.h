// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/results.h"
#include "turnscale/run/missing_path.h"

namespace turnscale {

/// Times, seconds, from which on the images show another view than just before, so that the map began anew: tracking
/// was good until then, hardly anything of it was found in the next image that repeats none, which is no blank one,
/// and the next map began as soon as the last was given up. Videos that were cut or joined look so, and recorders that
/// skip images without a word. `frames`: of the drive, refined, in the order of their numbers. `repeated`: numbers of
/// those that were taken for repeated images online, ascending. `seams`: when clips begin that follow others, seconds;
/// nothing is said of them.
std::vector<double> FindViewChanges(const std::vector<FrameResult>& frames, const std::vector<MapRestart>& restarts,
                                    const std::vector<int>& repeated = {}, const std::vector<double>& seams = {});

/// A part of the drive whose images all repeat the one before it, and are followed by another view or by none.
struct FrozenPart {
  double from = 0;    ///< time of the last image before it, seconds
  double to = 0;      ///< time of the first image after it; of its last one at the end of the drive
  double length = 0;  ///< of the path there, which is a guess
  bool at_end = false;
};

/// All such parts of half a second or more. `frames`: of the drive, refined, by their numbers; `repeated`: those that
/// were taken for repeated images online, ascending.
std::vector<FrozenPart> FindFrozenParts(const std::vector<FrameResult>& frames, const std::vector<int>& repeated);

/// The warning, one line, with times counted from `first_time`. `unit`: of the path's length.
std::string FrozenPartText(const FrozenPart& part, double first_time, const std::string& unit);

/// The warning, one line, with times counted from `first_time`; empty if there are none.
std::string ViewChangeText(const std::vector<double>& times, double first_time);

}  // namespace turnscale
