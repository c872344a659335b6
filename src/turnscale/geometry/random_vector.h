// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace turnscale {

/// A vector of `draw`'s numbers, the last component drawn first. As arguments of a constructor, they would be drawn in
/// the order that the compiler prefers.
template <int kSize, typename Draw>
Eigen::Matrix<double, kSize, 1> DrawVector(const Draw& draw) {
  Eigen::Matrix<double, kSize, 1> vector;
  for (int i = kSize - 1; i >= 0; --i) vector[i] = draw();
  return vector;
}

}  // namespace turnscale
