// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/export/geo_path.h"

namespace turnscale {

/// A path for programs that draw on maps.
struct GeoTrack {
  std::string name;
  std::vector<GeoPlace> places;
  std::vector<GeoPlace> turns;  ///< middles of the turns
  /// UTC time of the drive's time 0, seconds since 1970; without it the files have no times of day.
  std::optional<double> start_time;
  /// Heights are above the sea, as GPS receivers and maps give them and GPX and KML expect them; else they are left
  /// out.
  bool has_height = false;
};

/// GPX 1.1: one track. Speed (m/s) and sigmas stand in extensions.
std::string GpxText(const GeoTrack& track);

/// KML 2.2: the path as a gx:Track with speed and sigmas if there is a start time, else as a line; a point per turn. It
/// is drawn on the ground: heights are for those who read them.
std::string KmlText(const GeoTrack& track);

/// GeoJSON (RFC 7946): a line whose property coordinateProperties has one time, speed and sigma per position (null
/// where there is none), and a point per turn. Times are UTC if there is a start time; else `seconds` of the drive
/// alone. A line across the 180th meridian becomes a MultiLineString that is cut there, and each property a list per
/// part. Heights are a property, `height_m`: those of positions would be above the ellipsoid.
std::string GeoJsonText(const GeoTrack& track);

}  // namespace turnscale
