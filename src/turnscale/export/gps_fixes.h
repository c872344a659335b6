// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "turnscale/export/geo_path.h"

namespace turnscale {

/// A position from a GPS.
struct GpsFix {
  double time = 0;  ///< seconds of the drive
  GeoPoint point;
  double sigma = 5;         ///< metres, horizontal
  bool has_height = false;  ///< of the point
};

/// Reads a table with the columns time, latitude and longitude (degrees), and optionally height and sigma (metres), in
/// the order of time. Times are those of the drive's results; or seconds since 1970, or ISO 8601 with an
/// offset, which need `start_time`, the UTC time of the drive's time 0. Throws InputError that names file and line.
std::vector<GpsFix> ReadGpsFixes(const std::filesystem::path& path, std::optional<double> start_time);

/// The path laid on fixes by rotation and shift, without a change of scale. The sigmas include the drift of the path
/// (path_error.h), as the fixes may be far more accurate than it is.
struct FixPlacement {
  Placement placement;
  bool has_height = false;   ///< of the origin, and the tilt: from the heights of the fixes (fix_heights.h)
  double heading_sigma = 0;  ///< rad
  int fixes = 0;             ///< during the drive
  int outliers = 0;          ///< of them, not used
  double rms = 0;            ///< of the others' distances from the path, metres
  double scale = 1;          ///< by which the path would fit the fixes best: larger than 1 if it is too short
  double scale_sigma = 0;
  bool fits = true;  ///< if not, times or coordinates are wrong: the sigmas and the drift do not explain the distances
};

/// Robust to outliers: the start is the best of many pairs of fixes, then least squares with Tukey's weights. Fixes
/// outside of the drive are not used. Throws InputError if fewer than two fixes are left, or if they are too close to
/// each other to give a heading.
FixPlacement PlaceByFixes(const std::vector<LevelPlace>& path, const std::vector<GpsFix>& fixes);

}  // namespace turnscale
