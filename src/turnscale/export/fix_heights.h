// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace turnscale {

/// The height that a fix has, and where the path is at its time.
struct HeightOfFix {
  Eigen::Vector3d path = Eigen::Vector3d::Zero();  ///< level axes: right, ahead, up
  double height = 0;                               ///< metres
  double sigma = 1;                                ///< metres, of both
};

/// How a path lies in height.
struct HeightPlacement {
  double height = 0;  ///< where the path has its origin, metres
  /// Turns level axes to those of gravity: the level of a path is the mean over the car, so that the mean slope of the
  /// drive is missing in it.
  Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();
};

/// Height and tilt that fit best, robust to outliers. Mean slopes are small, so that a few fixes close to each other
/// hardly tilt the path. There has to be a fix.
HeightPlacement PlaceHeights(const std::vector<HeightOfFix>& fixes);

}  // namespace turnscale
