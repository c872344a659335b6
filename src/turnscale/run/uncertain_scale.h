// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/odometry/results.h"

namespace turnscale {

/// Parts of the measured path whose scale has a relative sigma of more than 0.3, such as a map that was lost before a
/// turn or the road showed its scale. A sigma of a logarithm does not bound the length there: where the unit is a
/// tenth of the right one, sigma times length is next to nothing. The time bounds it: the car moves there, too.
struct UncertainScale {
  double from = 0;      ///< time, seconds, where the longest part begins
  double to = 0;        ///< time, seconds, where it ends
  double seconds = 0;   ///< in which the camera moves in all of them
  double distance = 0;  ///< length of the path there, metres
  double expected = 0;  ///< the same at the mean speed of the rest, metres

  /// Error of the path's length that this suggests, metres.
  double length_error() const { return std::abs(expected - distance); }
  /// Mean speed of the rest, m/s.
  double usual_speed() const { return expected / seconds; }
};

/// `frames`: refined poses in metres. Empty if there is no such part, or hardly anything else.
std::optional<UncertainScale> FindUncertainScale(const std::vector<FrameResult>& frames);

/// The warning, one line; empty if the part matters little for a path of this length (metres).
std::string UncertainScaleText(const UncertainScale& part, double length);

}  // namespace turnscale
