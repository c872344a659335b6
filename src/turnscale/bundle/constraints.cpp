// SPDX-License-Identifier: MIT
#include "turnscale/bundle/constraints.h"

namespace turnscale {

double DistanceError(const DistanceConstraint& held, const std::vector<Eigen::Vector3d>& centres) {
  return (centres[held.camera_a] - centres[held.camera_b]).norm() / held.distance - 1.0;
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
