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

/// Share of the cells (those of CellWeights) in which most pixels are counted (one flag per undistorted pixel), of the
/// cells with pixels in the same rows: neither a crowd nor a dashboard below decides. 0 if there is no such cell.
double ShareOfCells(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels,
                    const std::vector<char>& is_counted);

}  // namespace turnscale
