// SPDX-License-Identifier: MIT
#include "turnscale/io/turn_warning.h"

#include <cmath>

#include <fmt/format.h>

namespace turnscale {

std::string TurnWarning(const ScaleEstimate& estimate, const std::function<std::string(int)>& name_of,
                        const std::string& suspects) {
  const TurnTest& test = estimate.test;
  const bool contradicted = test.contradicted && test.worst_turn >= 0;
  // Else they are used because of the calibration, which has its own warning, or by choice.
  if (!estimate.fell_back || (!contradicted && estimate.converged)) return {};
  if (contradicted && estimate.height_conflict && estimate.height_conflict->contradicts_turns)
    return fmt::format(
        "the turns are inconsistent with the given camera height, by {:.0f} % of scale, and consistent without it: the "
        "trajectory uses single-turn scales; check the camera height and the lever arm",
        100 * test.disagreement);
  const std::string problem =
      contradicted ? fmt::format("the turns are inconsistent by {:.0f} % of scale, most of all the one at {}",
                                 100 * test.disagreement, name_of(test.worst_turn))
                   : "the scale estimate did not converge";
  return fmt::format("{}: the trajectory uses single-turn scales; check {}", problem, suspects);
}

std::string HeightWarning(const HeightConflict& conflict, double lever_arm) {
  const double ratio = conflict.given / conflict.found;
  return fmt::format(
      "lever arm and camera height disagree by {:.0f} %: with the lever arm {:.2f} m the turns give a height of {:.2f} "
      "+-{:.2f} m, not {:.2f} m; the given height implies a lever arm of {:.2f} m: measure both again",
      100 * std::abs(ratio - 1), lever_arm, conflict.found, conflict.found_sigma, conflict.given, ratio * lever_arm);
}

}  // namespace turnscale
