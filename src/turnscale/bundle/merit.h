// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"

namespace turnscale {

/// How steps under constraints are judged: by the cost plus penalties * |constraints|. It falls along every step of
/// sequential quadratic programming as long as each penalty exceeds the constraint's multiplier.
class Merit {
 public:
  /// The distances have to outlive the merit.
  explicit Merit(const std::vector<DistanceConstraint>& distances);

  /// Makes each penalty twice its multiplier at least; penalties that are no longer needed sink by halves.
  void Cover(const Eigen::VectorXd& multipliers);

  /// Sum of penalty * |distance error|.
  double Violation(const std::vector<Eigen::Vector3d>& centres) const;

 private:
  const std::vector<DistanceConstraint>& distances_;
  Eigen::VectorXd penalties_;
};

}  // namespace turnscale
