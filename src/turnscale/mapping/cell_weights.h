// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// Weights of features at these undistorted pixels, by how many are close to one another: those in one square cell, an
/// eighth of the focal length wide (7 degrees at the image's centre, less towards the edges of a wide image), have a
/// weight of `most` together, and each of 1 at most. What is seen of a vehicle ahead stays in sight while features of
/// the scene come and go: by their number, they would dominate the pose.
std::vector<double> CellWeights(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels, double most);

/// Width of the part of the image that pixels lie in, as a share of the width of the part that all lie in: from the
/// 10th to the 90th percentile, weighed by CellWeights, so that a few of them decide nothing. `is_counted`: one flag
/// per pixel. 0 if none is counted.
double ShareOfWidth(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels,
                    const std::vector<char>& is_counted);

}  // namespace turnscale
