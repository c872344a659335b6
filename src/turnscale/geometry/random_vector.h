// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace turnscale {

/// A vector of numbers that `draw` gives, the last component drawn first. As arguments of a constructor, they would be
/// drawn in an order that the compiler chooses; this one is GCC's.
template <int kSize, typename Draw>
Eigen::Matrix<double, kSize, 1> DrawVector(const Draw& draw) {
  Eigen::Matrix<double, kSize, 1> vector;
  for (int i = kSize - 1; i >= 0; --i) vector[i] = draw();
  return vector;
}

}  // namespace turnscale
