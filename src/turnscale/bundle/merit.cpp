// SPDX-License-Identifier: MIT
#include "turnscale/bundle/merit.h"

#include <cmath>
#include <cstddef>

#include "turnscale/bundle/constraints.h"

namespace turnscale {

Merit::Merit(const std::vector<DistanceConstraint>& distances)
    : distances_(distances), penalties_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(distances.size()))) {}

void Merit::Cover(const Eigen::VectorXd& multipliers) {
  const Eigen::VectorXd sizes = multipliers.cwiseAbs();
  penalties_ = (2.0 * sizes).cwiseMax(0.5 * (penalties_ + sizes));
}

double Merit::Violation(const std::vector<Eigen::Vector3d>& centres) const {
  double sum = 0;
  for (std::size_t i = 0; i < distances_.size(); ++i) {
    sum += penalties_[static_cast<Eigen::Index>(i)] * std::abs(DistanceError(distances_[i], centres));
  }
  return sum;
}

}  // namespace turnscale
