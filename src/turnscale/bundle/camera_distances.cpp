// SPDX-License-Identifier: MIT
#include "turnscale/bundle/camera_distances.h"

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

double MeasuredDistanceCost(const std::vector<MeasuredDistance>& measured,
                            const std::vector<Eigen::Vector3d>& centres) {
  double cost = 0;
  for (const MeasuredDistance& entry : measured) {
    const double error = DistanceError(entry.between, centres) / entry.sigma;
    cost += 0.5 * error * error;
  }
  return cost;
}

template <int kDof>
void AddMeasuredDistances(const BundleProblem& problem, const BundleStructure& structure, const BundleState& state,
                          NormalEquations<kDof>& equations) {
  equations.cost += MeasuredDistanceCost(problem.measured_distances, state.centres);
  for (const auto& [between, sigma] : problem.measured_distances) {
    const LinearizedDistance linear = LinearizeDistance(between, state.centres);
    const Eigen::Vector3d gradient = linear.value / (sigma * sigma) * linear.gradient;
    const int a = structure.column_of_camera[between.camera_a];
    const int b = structure.column_of_camera[between.camera_b];
    // The unknown is delta, with the centre at c - delta.
    if (a >= 0) equations.camera_gradient[a].template tail<3>() -= gradient;
    if (b >= 0) equations.camera_gradient[b].template tail<3>() += gradient;
  }
}

template <int kDof>
void AddMeasuredDistances(const BundleProblem& problem, const BundleStructure& structure, const BundleState& state,
                          HessianKind kind, SchurSystem<kDof>& system) {
  for (std::size_t i = 0; i < problem.measured_distances.size(); ++i) {
    const auto& [between, sigma] = problem.measured_distances[i];
    const LinearizedDistance linear = LinearizeDistance(between, state.centres);
    Eigen::Matrix3d hessian = linear.gradient * linear.gradient.transpose();
    if (kind == HessianKind::kNewton) hessian += linear.value * linear.curvature;
    AddToPair(structure, between, structure.measured_distance_block[i], hessian / (sigma * sigma), system);
  }
}

template void AddMeasuredDistances<3>(const BundleProblem&, const BundleStructure&, const BundleState&,
                                      NormalEquations<3>&);
template void AddMeasuredDistances<6>(const BundleProblem&, const BundleStructure&, const BundleState&,
                                      NormalEquations<6>&);
template void AddMeasuredDistances<3>(const BundleProblem&, const BundleStructure&, const BundleState&, HessianKind,
                                      SchurSystem<3>&);
template void AddMeasuredDistances<6>(const BundleProblem&, const BundleStructure&, const BundleState&, HessianKind,
                                      SchurSystem<6>&);

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
