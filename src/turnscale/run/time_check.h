// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "turnscale/odometry/results.h"

namespace turnscale {

/// Warnings where no car moves as the poses and their times say, a line each. Wrong times make speeds wrong, and with
/// them the slip of the tyres and the scale.
///
/// * Images that are missing although the times are even: between two images the car moves 1.6 to 4 times as far as
///   before and after, in at least three steps and 1 % of them.
/// * Times that are uneven although the motion is even, as of images that are stamped when they arrive: of two steps
///   that follow one another, one takes at least twice as long, but the car goes about as far: in at least ten places,
///   10 % of the steps, and 70 % of such pairs. Of trajectories up to scale, only this is reported.
/// * Images that are repeated: from one image to the next, the moving car jumps against its direction of travel, at
///   least three times as far as before and after.
/// * Times that pass too slowly: more than 6 m/s^2 sideways in the median of the turns that were used.
/// * Times that pass too fast, such as those of slow motion: less than 0.25 m/s^2, with at least two turns.
///
/// `frames`: poses in metres, or up to scale. `first_time`: the warnings
/// count their times from it.
std::vector<std::string> TimeWarnings(const std::vector<FrameResult>& frames, const std::vector<TurnResult>& turns,
                                      double first_time = 0);

/// Of turns that no car takes: accelerations sideways (m/s^2), each with the angle of its turn. Slow ones only count if
/// there are as many turns as `fewest_slow`. `check` is what to check, the end of "check ...".
std::optional<std::string> UnusualTurnsWarning(std::vector<std::pair<double, double>> sideways,
                                               const std::string& check, std::size_t fewest_slow = 2);

}  // namespace turnscale
