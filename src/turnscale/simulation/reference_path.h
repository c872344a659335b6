// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/simulation/route.h"
#include "turnscale/simulation/vehicle.h"

namespace turnscale {

/// A leg as it can be driven: its points smoothed and evenly spaced.
struct ReferencePath {
  double spacing = 0;                     ///< metres
  std::vector<Eigen::Vector2d> position;  ///< (x, z)
  std::vector<double> heading;            ///< of the way ahead, rad, 0 along z, positive to the right, not wrapped
  std::vector<double> curvature;          ///< 1/m, positive to the right
  std::vector<double> speed;              ///< wanted, m/s

  double Length() const { return spacing * static_cast<double>(position.size() - 1); }
};

/// Smooths a leg over half a metre, a recording (a leg with speeds) over at least 0.2 s: as much as keeps the noise of
/// its points, a few centimetres, out of the steering. The ends stay where they are.
ReferencePath MakeReferencePath(const RouteLeg& leg);

/// Where the path is after a distance; beyond its ends it goes straight on.
struct PathPlace {
  Eigen::Vector2d position = {0, 0};
  double heading = 0;
  double curvature = 0;
};
PathPlace PlaceAt(const ReferencePath& path, double distance);

/// Distance along the path to the place nearest to a position, searched around `guess`.
double Project(const ReferencePath& path, const Eigen::Vector2d& position, double guess);

/// Speeds with which to start and end (m/s).
struct EndSpeeds {
  double start = 0;
  double end = 0;
};

/// Speeds (m/s, not negative) every `interval` seconds that bring a car from the path's start to its end: the path's
/// own, lower in curves and where the wheels could not be turned as fast, within the limits of acceleration, and
/// without jerks. An end whose speed the path does not allow is driven at what it allows.
std::vector<double> PlanSpeeds(const CarOptions& options, const ReferencePath& path, const EndSpeeds& ends,
                               double interval);

}  // namespace turnscale
