// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/export/geo_frame.h"
#include "turnscale/run/result_folder.h"

namespace turnscale {

/// A place of the car in level axes: x right, y ahead (both at the first pose), z up.
struct LevelPlace {
  double time = 0;  ///< seconds of the drive
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::optional<SpeedReading> speed;
  double sigma = 0;  ///< relative, of the scale
  int frame = 0;
};

/// The path of a run in level axes, its first pose at the origin. Throws InputError if the run has no path in metres.
std::vector<LevelPlace> LevelPath(const ResultFolder& results, const std::string& name);

/// Where the first pose of a path lies on Earth.
struct Placement {
  GeoPoint origin;
  double heading = 0;                                        ///< of the car there, rad clockwise from north
  Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();  ///< turns the path's level axes first
};

/// A place on Earth along the drive.
struct GeoPlace {
  double time = 0;  ///< seconds of the drive
  GeoPoint point;
  std::optional<SpeedReading> speed;
  double sigma = 0;
};

/// East and north of a place in level axes, if the first pose is at the origin with this heading.
Eigen::Vector3d EastNorthUp(const Eigen::Vector3d& level, double heading);

/// The path on Earth, every `interval` seconds at most (0: every frame), with the last place.
std::vector<GeoPlace> PlaceOnEarth(const std::vector<LevelPlace>& path, const Placement& placement,
                                   double interval = 0);

}  // namespace turnscale
