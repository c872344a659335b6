// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

namespace turnscale {

/// Position of a car along its path at a time.
struct PathReading {
  double time = 0;       ///< seconds, ascending
  double position = 0;   ///< metres along the path; falls while the car reverses
  bool measured = true;  ///< false: predicted or interpolated, so `position` is not used
};

/// Speed at a time.
struct SpeedReading {
  double time = 0;   ///< seconds
  double speed = 0;  ///< m/s, negative in reverse
  double sigma = 0;  ///< standard deviation, m/s
};

/// The reading of a time, to a microsecond, if there is one. Readings are in the order of time.
std::optional<SpeedReading> SpeedAt(const std::vector<SpeedReading>& readings, double time);

struct SpeedSmootherOptions {
  /// How fast the acceleration of a car changes: random walk, m/s^2 per square root of a second.
  double acceleration_walk = 1.2;
  /// Relative standard deviation of a distance across readings that are not measured.
  double gap_sigma = 0.2;
};

/// Speed at each reading, from all readings: the Kalman smoother of a car whose acceleration is a random walk and whose
/// positions have white noise. The noise of the positions is estimated from the readings by maximum likelihood.
/// Deviations of more than three sigma are down-weighted, with the inverse of their square. Empty if fewer than three
/// readings are measured. The first reading has to be a measured one.
std::vector<SpeedReading> SmoothSpeed(const std::vector<PathReading>& readings,
                                      const SpeedSmootherOptions& options = {});

}  // namespace turnscale
