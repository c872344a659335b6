// SPDX-License-Identifier: MIT
#include "turnscale/bundle/constraints.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "turnscale/base/error.h"

namespace turnscale {

double DistanceError(const DistanceConstraint& held, const std::vector<Eigen::Vector3d>& centres) {
  return (centres[held.camera_a] - centres[held.camera_b]).norm() / held.distance - 1.0;
}

double LargestDistanceError(const std::vector<DistanceConstraint>& distances,
                            const std::vector<Eigen::Vector3d>& centres) {
  double largest = 0;
  for (const DistanceConstraint& held : distances) largest = std::max(largest, std::abs(DistanceError(held, centres)));
  return largest;
}

void RequireSeparateCentres(const BundleProblem& problem, const std::vector<Eigen::Vector3d>& centres) {
  const auto require = [&](const DistanceConstraint& held, const char* list, std::size_t i) {
    if (DistanceError(held, centres) > -1.0) return;
    throw NumericalError("bundle problem: " + std::string(list) + "[" + std::to_string(i) +
                         "] is between two cameras at the same position; the direction between them is undefined");
  };
  for (std::size_t i = 0; i < problem.distances.size(); ++i) require(problem.distances[i], "distances", i);
  for (std::size_t i = 0; i < problem.measured_distances.size(); ++i)
    require(problem.measured_distances[i].between, "measured_distances", i);
}

LinearizedDistance LinearizeDistance(const DistanceConstraint& held, const std::vector<Eigen::Vector3d>& centres) {
  const Eigen::Vector3d difference = centres[held.camera_a] - centres[held.camera_b];
  const double length = difference.norm();
  const Eigen::Vector3d direction = difference / length;
  LinearizedDistance linear;
  linear.value = length / held.distance - 1.0;
  linear.gradient = direction / held.distance;
  linear.curvature = (Eigen::Matrix3d::Identity() - direction * direction.transpose()) / (held.distance * length);
  return linear;
}

}  // namespace turnscale
