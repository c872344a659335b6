// SPDX-License-Identifier: MIT
#include "turnscale/bundle/measured_distances.h"

#include <cstddef>

#include "turnscale/bundle/constraints.h"

namespace turnscale {

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

}  // namespace turnscale
