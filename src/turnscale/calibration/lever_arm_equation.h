// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "turnscale/geometry/angle.h"

namespace turnscale {

/// What a step of a metric drive says of the lever arm and of the drive's yaw:
///   sideways = turn L + slip() c + way yaw
struct LeverArmEquation {
  double turn = 0;      ///< 2 sin(psi/2) of each frame, summed
  double speed = 0;     ///< m/s, negative in reverse
  double way = 0;       ///< metres, negative in reverse
  double sideways = 0;  ///< metres, without what the usual roll height adds
  double roll = 0;      ///< rad
  double begin = 0;     ///< seconds
  double end = 0;       ///< seconds
  int drive = 0;

  /// By at least 2 deg.
  bool turning() const { return std::abs(turn) >= 2 / kDegreesPerRadian; }
  double slip() const { return -speed * std::abs(speed) * turn; }
  double duration() const { return end - begin; }
};

/// An equation in a robust fit.
struct FittedEquation {
  LeverArmEquation equation;
  Eigen::VectorXd row;   ///< derivatives by the unknowns
  double off = 0;        ///< weighted residual, metres
  double curvature = 0;  ///< derivative of `off` by the residual
};

/// Whether two equations that follow each other are of the same turn, or of the same way between two.
inline bool AreOfOneSegment(const LeverArmEquation& a, const LeverArmEquation& b) {
  return a.drive == b.drive && a.turning() == b.turning() && !(a.turning() && a.turn * b.turn < 0);
}

}  // namespace turnscale
