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

/// Share of the cells (those of CellWeights) in which most pixels are counted, however many there are in a cell. The
/// cells that are compared have pixels, and are in the rows (from the 10th to the 90th percentile) of cells in which
/// most pixels are of the second kind: what is seen above and below does not count. One flag per undistorted pixel. 0
/// if there is no such row.
double ShareOfCells(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels,
                    const std::vector<char>& is_counted, const std::vector<char>& is_of_rows);

}  // namespace turnscale
