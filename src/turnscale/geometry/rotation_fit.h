// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>

namespace turnscale {

/// Rotation that takes `first` directions onto `second` ones best, robustly: the sum of the angles (not of their
/// squares) is made small, so that near points, which move by more than the rotation, do not pull it away.
/// Both lists have the same length, at least two; vectors of any length.
Eigen::Quaterniond FitRotation(const std::vector<Eigen::Vector3d>& first, const std::vector<Eigen::Vector3d>& second);

}  // namespace turnscale
