// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Motion between two views by matches, some of which may be wrong.
struct EssentialMotion {
  RigidTransform second_from_first;  ///< unit translation
  int agreeing = 0;                  ///< matches, far ones included
  std::vector<char> inlier;  ///< one flag per match: it agrees, and is near enough for a depth; empty: no motion
};

/// Five-point essential matrix with RANSAC, and the one of its four motions that puts most points in front of both
/// cameras. `first`, `second`: rays of the matches, at depth 1. A match agrees if it is at most `max_error` from its
/// epipolar line, in the plane at depth 1. Needs five matches.
EssentialMotion FindEssentialMotion(const std::vector<Eigen::Vector3d>& first,
                                    const std::vector<Eigen::Vector3d>& second, double max_error);

}  // namespace turnscale
