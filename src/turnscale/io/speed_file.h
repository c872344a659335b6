// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace turnscale {

/// A car's speed over time, as its wheels or a GPS measured it.
struct SpeedLog {
  std::vector<double> times;   ///< seconds, growing
  std::vector<double> speeds;  ///< m/s, of the same number
  bool names_unit = false;     ///< of the speeds; else the numbers were taken for m/s

  /// Metres driven between two times, by straight lines between the measurements; nothing outside of them.
  std::optional<double> Distance(double begin, double end) const;
};

/// Reads lines `time, speed` (s, m/s; comma or blanks); # begins a comment, and a first line of words is a heading,
/// also after a #. Where it names columns `time` and `speed` (or `t`, `v`), there may be others. A unit in the name of
/// the speed is converted: `speed_kmh`, `speed [km/h]`, `speed_mph`, `v_mps`, knots; so is one of the time, such as
/// `time_ms`. Times without a unit are read as InSeconds does. Throws InputError that names file and line where a
/// number is missing, not finite, or negative, a speed without a unit is above 70, a unit is not known, times do not
/// grow, or there are more than two columns without those names; also as RefuseSparseTimes if there are ten speeds or
/// more and their times have no unit.
SpeedLog ReadSpeedFile(const std::filesystem::path& path);

}  // namespace turnscale
