// SPDX-License-Identifier: MIT
#include "turnscale/bundle/kkt_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>

namespace turnscale {
namespace {

/// Without the first camera's distance to anything known, only the constraints hold the scale: S alone is singular.
/// Adding weight * D D^T makes it definite and, with the gradient changed to match, leaves the solution as it is.
template <int kDof>
void Augment(const BundleProblem& problem, const BundleStructure& structure,
             const std::vector<LinearizedDistance>& constraints, const Eigen::MatrixXd& constraint_gradients,
             double share, SchurSystem<kDof>& system) {
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const DistanceConstraint& held = problem.distances[i];
    double weight = 0;
    for (const int camera : {held.camera_a, held.camera_b}) {
      const int column = structure.column_of_camera[camera];
      if (column >= 0) weight += system.blocks[column].template bottomRightCorner<3, 3>().trace();
    }
    weight = std::abs(weight) * held.distance * held.distance;
    AddToPair(structure, held, structure.distance_block[i],
              weight * constraints[i].gradient * constraints[i].gradient.transpose(), system);
    system.gradient += weight * share * constraints[i].value * constraint_gradients.col(static_cast<Eigen::Index>(i));
  }
}

}  // namespace

template <int kDof>
Eigen::MatrixXd ConstraintGradients(const BundleProblem& problem, const BundleStructure& structure,
                                    const std::vector<LinearizedDistance>& constraints) {
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(kDof * static_cast<Eigen::Index>(structure.camera_of_column.size()),
                                                    static_cast<Eigen::Index>(constraints.size()));
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const DistanceConstraint& held = problem.distances[i];
    const int a = structure.column_of_camera[held.camera_a];
    const int b = structure.column_of_camera[held.camera_b];
    const Eigen::Index column = static_cast<Eigen::Index>(i);
    // The unknown is delta, with the centre at c - delta.
    if (a >= 0) gradients.col(column).segment<3>(kDof * a + kDof - 3) = -constraints[i].gradient;
    if (b >= 0) gradients.col(column).segment<3>(kDof * b + kDof - 3) = constraints[i].gradient;
  }
  return gradients;
}

template <int kDof>
void AddConstraintCurvature(const BundleProblem& problem, const BundleStructure& structure,
                            const std::vector<LinearizedDistance>& constraints, const Eigen::VectorXd& multipliers,
                            SchurSystem<kDof>& system) {
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    AddToPair(structure, problem.distances[i], structure.distance_block[i],
              multipliers[static_cast<Eigen::Index>(i)] * constraints[i].curvature, system);
  }
}

template <int kDof>
bool SolveKkt(const BundleProblem& problem, const BundleStructure& structure, const NormalEquations<kDof>& equations,
              const std::vector<LinearizedDistance>& constraints, const Eigen::MatrixXd& constraint_gradients,
              double share, SchurSystem<kDof>& system, CameraSolver<kDof>& solver, KktStep& step) {
  const Eigen::Index count = static_cast<Eigen::Index>(constraints.size());
  Augment(problem, structure, constraints, constraint_gradients, share, system);
  if (!solver.Factorize(system.blocks)) return false;
  step.multipliers.resize(count);
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) values[i] = share * constraints[static_cast<std::size_t>(i)].value;
  Eigen::VectorXd half_solved = solver.SolveLower(-system.gradient);
  if (count > 0) {
    const Eigen::MatrixXd reaction = solver.SolveLower(constraint_gradients);
    const Eigen::LDLT<Eigen::MatrixXd> coupling(reaction.transpose() * reaction);
    step.multipliers = coupling.solve(values + reaction.transpose() * half_solved);
    half_solved -= reaction * step.multipliers;
  }
  step.cameras = solver.SolveUpper(half_solved);
  BackSubstitute(structure, equations, system, step.cameras, step.points);
  if (!step.cameras.allFinite()) return false;

  // The step's own equation gives the curvature along it: step^T (H + damping) step = -slope + multipliers^T values.
  step.slope = 0;
  double damped = system.damping.dot(step.cameras.cwiseAbs2());
  for (std::size_t i = 0; i < equations.camera_gradient.size(); ++i) {
    const Eigen::Index row = kDof * static_cast<Eigen::Index>(i);
    step.slope += equations.camera_gradient[i].dot(step.cameras.template segment<kDof>(row));
  }
  for (std::size_t i = 0; i < equations.point_gradient.size(); ++i) {
    step.slope += equations.point_gradient[i].dot(step.points[i]);
    damped += system.point_damping[i].dot(step.points[i].cwiseAbs2());
  }
  const double curvature = -step.slope + step.multipliers.dot(values) - damped;
  step.predicted_decrease = -step.slope - 0.5 * curvature;
  return true;
}

template <int kDof>
double KktResidual(const NormalEquations<kDof>& equations, const Eigen::MatrixXd& constraint_gradients,
                   const Eigen::VectorXd& multipliers) {
  using CameraVector = typename NormalEquations<kDof>::CameraVector;
  CameraVector mean = CameraVector::Zero();
  for (const auto& hessian : equations.camera_hessian) mean += hessian.diagonal().cwiseAbs();
  mean /= std::max<double>(1.0, static_cast<double>(equations.camera_hessian.size()));
  const auto scaled = [](double gradient, double curvature, double stand_in) {
    const double weight = curvature != 0 ? std::abs(curvature) : stand_in;
    return weight > 0 ? std::abs(gradient) / std::sqrt(weight) : std::abs(gradient);
  };
  double largest = 0;
  for (std::size_t i = 0; i < equations.camera_gradient.size(); ++i) {
    CameraVector gradient = equations.camera_gradient[i];
    const Eigen::Index row = kDof * static_cast<Eigen::Index>(i);
    gradient += constraint_gradients.middleRows<kDof>(row) * multipliers;
    for (int k = 0; k < kDof; ++k) {
      largest = std::max(largest, scaled(gradient[k], equations.camera_hessian[i](k, k), mean[k]));
    }
  }
  for (std::size_t i = 0; i < equations.point_gradient.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      largest = std::max(largest, scaled(equations.point_gradient[i][k], equations.point_hessian[i](k, k), 0));
    }
  }
  return largest;
}

#define TURNSCALE_INSTANTIATE(kDof)                                                                          \
  template Eigen::MatrixXd ConstraintGradients<kDof>(const BundleProblem&, const BundleStructure&,           \
                                                     const std::vector<LinearizedDistance>&);                \
  template void AddConstraintCurvature<kDof>(const BundleProblem&, const BundleStructure&,                   \
                                             const std::vector<LinearizedDistance>&, const Eigen::VectorXd&, \
                                             SchurSystem<kDof>&);                                            \
  template bool SolveKkt<kDof>(const BundleProblem&, const BundleStructure&, const NormalEquations<kDof>&,   \
                               const std::vector<LinearizedDistance>&, const Eigen::MatrixXd&, double,       \
                               SchurSystem<kDof>&, CameraSolver<kDof>&, KktStep&);                           \
  template double KktResidual<kDof>(const NormalEquations<kDof>&, const Eigen::MatrixXd&, const Eigen::VectorXd&)
TURNSCALE_INSTANTIATE(3);
TURNSCALE_INSTANTIATE(6);
#undef TURNSCALE_INSTANTIATE

}  // namespace turnscale
