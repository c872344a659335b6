// SPDX-License-Identifier: MIT
#include "turnscale/run/turn_warning.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "turnscale/geometry/angle.h"

namespace turnscale {

std::string TurnWarning(const ScaleEstimate& estimate, const std::function<std::string(int)>& name_of,
                        const std::string& suspects) {
  const TurnTest& test = estimate.test;
  const bool contradicted = test.contradicted && test.worst_turn >= 0;
  // Turns may also be used singly because of the calibration, which has its own warning, or by choice.
  if (!contradicted && estimate.converged) return {};
  if (!estimate.uses_single_turns) return fmt::format("the scale estimate did not converge: check {}", suspects);
  const std::string problem = contradicted
                                  ? fmt::format("the turns disagree on the scale by {:.0f} % on average, most at {}",
                                                100 * test.disagreement, name_of(test.worst_turn))
                                  : "the scale estimate did not converge";
  return fmt::format("{}; the trajectory uses the scale of each turn instead of the joint estimate: check {}", problem,
                     suspects);
}

std::string HeightWarning(const HeightConflict& conflict, double lever_arm, const std::string& remedy) {
  constexpr double kLargeRatio = 1.5;
  const double ratio = conflict.given / conflict.found;
  const double factor = std::max(ratio, 1 / ratio);
  const std::string difference = factor > kLargeRatio ? fmt::format("a factor of {:.1f}", factor)
                                                      : fmt::format("{:.0f} %", 100 * std::abs(ratio - 1));
  return fmt::format(
      "lever arm and camera height disagree by {}: with the lever arm {:.2f} m the turns give a height of {:.2f} "
      "+-{:.2f} m, not {:.2f} m; the given height implies a lever arm of {:.2f} m{}: {}",
      difference, lever_arm, conflict.found, conflict.found_sigma, conflict.given, ratio * lever_arm,
      conflict.contradicts_turns ? "; the trajectory uses the lever arm alone" : "", remedy);
}

std::string SlipWarning(const SlipConflict& conflict) {
  return fmt::format(
      "the turns show a side slip of {:.4f} s^2/m, far from the expected {:.4f} +-{:.4f}: check the times of the "
      "images and the lever arm, as errors of both act like slip{}",
      conflict.found, conflict.given, conflict.given_sigma, conflict.given == 0 ? ", and leave out --side-slip 0" : "");
}

std::string StabilisationWarning(const ScaleEstimate& estimate) {
  const std::string remedy =
      "record without image stabilisation, or give the measured height of the camera instead of the lever arm";
  const std::optional<ImageLag>& lag = estimate.image_lag;
  if (lag && !lag->is_used)
    return fmt::format(
        "the principal point of the calibration may be a little off, or the images stabilised: either explains what "
        "the "
        "turns show, and the sigma of the scale allows for both (+-{:.0f} %); have the calibration estimated by "
        "--camera-refine, {}",
        100 * lag->scale_error, remedy);
  std::string text = "the images seem to be stabilised: ";
  if (lag)
    text += fmt::format("in turns their orientation {} the car's by {:.2f} +-{:.2f} s, for which the scale allows{}; ",
                        lag->found > 0 ? "lags behind" : "is ahead of", std::abs(lag->found), lag->found_sigma,
                        lag->is_confirmed()
                            ? ", with a larger sigma"
                            : fmt::format(" (+-{:.0f} %, as a principal point that is a little off looks the same)",
                                          100 * lag->scale_error));
  if (const std::optional<ImageSmoothing>& smoothing = estimate.image_smoothing)
    text += fmt::format(
        "they begin to turn before the car does, and turn on after it, by which{} the scale may be off by {:.0f} % or "
        "more; ",
        lag ? "" : ", or by a lag that the turns do not show,", 100 * smoothing->scale_error);
  return text + remedy;
}

std::string YawWarning(const YawConflict& conflict, const std::string& remedy) {
  // Turns and straights show a yaw that differs from the given one to either side.
  if (std::abs(conflict.found) < 2 * conflict.found_sigma)
    return "the turns of the drive show another camera yaw than its straights: check the calibration, the times of the "
           "images and whether the camera is loose";
  return fmt::format(
      "the drive gives a camera yaw {:.1f} +-{:.1f} deg further {} than the camera-to-vehicle rotation, whose "
      "sigma is {:.1f} deg; the trajectory uses the yaw from the drive: {}",
      InDegrees(std::abs(conflict.found)), InDegrees(conflict.found_sigma), conflict.found > 0 ? "right" : "left",
      InDegrees(conflict.given_sigma), remedy);
}

}  // namespace turnscale
