// SPDX-License-Identifier: MIT
#include "turnscale/export/geo_frame.h"

#include <cmath>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// WGS 84.
constexpr double kSemiMajor = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kSquaredEccentricity = kFlattening * (2 - kFlattening);

double NormalRadius(double sine) { return kSemiMajor / std::sqrt(1 - kSquaredEccentricity * sine * sine); }

Eigen::Vector3d EarthFromGeo(const GeoPoint& place) {
  const double latitude = place.latitude / kDegreesPerRadian;
  const double longitude = place.longitude / kDegreesPerRadian;
  const double normal = NormalRadius(std::sin(latitude));
  const double across = (normal + place.height) * std::cos(latitude);
  return {across * std::cos(longitude), across * std::sin(longitude),
          (normal * (1 - kSquaredEccentricity) + place.height) * std::sin(latitude)};
}

// Fixed-point iteration: each step gains more than two digits near the surface.
GeoPoint GeoFromEarth(const Eigen::Vector3d& earth) {
  constexpr int kSteps = 8;
  const double across = std::hypot(earth.x(), earth.y());
  double latitude = std::atan2(earth.z(), across * (1 - kSquaredEccentricity));
  for (int i = 0; i < kSteps; ++i) {
    const double sine = std::sin(latitude);
    latitude = std::atan2(earth.z() + kSquaredEccentricity * NormalRadius(sine) * sine, across);
  }
  const double sine = std::sin(latitude);
  const double cosine = std::cos(latitude);
  const double height = across * cosine + earth.z() * sine - kSemiMajor * kSemiMajor / NormalRadius(sine);
  return {latitude * kDegreesPerRadian, std::atan2(earth.y(), earth.x()) * kDegreesPerRadian, height};
}

}  // namespace

GeoFrame::GeoFrame(const GeoPoint& origin) : origin_(EarthFromGeo(origin)) {
  const double latitude = origin.latitude / kDegreesPerRadian;
  const double longitude = origin.longitude / kDegreesPerRadian;
  const Eigen::Vector3d up(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                           std::sin(latitude));
  const Eigen::Vector3d east(-std::sin(longitude), std::cos(longitude), 0);
  local_from_earth_ << east.transpose(), up.cross(east).transpose(), up.transpose();
}

Eigen::Vector3d GeoFrame::ToLocal(const GeoPoint& place) const {
  return local_from_earth_ * (EarthFromGeo(place) - origin_);
}

GeoPoint GeoFrame::FromLocal(const Eigen::Vector3d& east_north_up) const {
  return GeoFromEarth(origin_ + local_from_earth_.transpose() * east_north_up);
}

}  // namespace turnscale
