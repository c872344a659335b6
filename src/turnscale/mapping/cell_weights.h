// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// Weights of features at these pixels, by how many share a part of the image: those in one square cell, of an eighth
/// of the focal length (7 degrees), have a weight of `most` together, and each of 1 at most. What is seen of a vehicle
/// ahead stays in sight while features of the scene come and go: by their number, it would outvote the scene.
std::vector<double> CellWeights(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels, double most);

}  // namespace turnscale
