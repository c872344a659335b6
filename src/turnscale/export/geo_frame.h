// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace turnscale {

/// A place on the WGS 84 ellipsoid.
struct GeoPoint {
  double latitude = 0;   ///< degrees, north positive
  double longitude = 0;  ///< degrees, east positive
  double height = 0;     ///< metres, above the ellipsoid or the sea as its source has it
};

/// Local axes east, north, up (metres) at a place.
class GeoFrame {
 public:
  explicit GeoFrame(const GeoPoint& origin);

  Eigen::Vector3d ToLocal(const GeoPoint& place) const;
  /// The longitude is within [-180, 180).
  GeoPoint FromLocal(const Eigen::Vector3d& east_north_up) const;

 private:
  Eigen::Vector3d origin_;  ///< Earth-centred, Earth-fixed, metres
  Eigen::Matrix3d local_from_earth_;
};

}  // namespace turnscale
