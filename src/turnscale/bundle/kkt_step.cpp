// SPDX-License-Identifier: MIT
#include "turnscale/bundle/kkt_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

#include <Eigen/Cholesky>

#include "turnscale/bundle/parts.h"
#include "turnscale/bundle/reprojection.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

/// Without the first camera's distance to anything known, only the constraints hold the scale: S alone is singular.
/// Adding weight * D D^T makes it definite and, with the gradient changed to match, leaves the solution as it is.
template <int kDof>
void Augment(const BundleProblem& problem, const BundleStructure& structure,
             const std::vector<LinearizedDistance>& constraints, const ConstraintMatrix& constraint_gradients,
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

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double PointCost(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state, std::size_t point,
                 const Eigen::Vector3d& position, double huber_threshold) {
  double cost = 0;
  for (int k = structure.first_observation[point]; k < structure.first_observation[point + 1]; ++k) {
    const SolverObservation& seen = structure.observations[k];
    const Eigen::Vector3d x_in_camera = state.rotations[seen.camera] * (position - state.centres[seen.camera]);
    if (!IsInFront(x_in_camera)) return kInfinity;
    cost += HuberCost(ReprojectionResidual(pinhole, x_in_camera, seen.pixel, seen.inverse_sigma).squaredNorm(),
                      huber_threshold);
  }
  return cost;
}

/// Limits of the minimisation of one point: iterations, and the share of the cost below which a gain is none.
constexpr int kPointIterations = 10;
constexpr double kSettled = 1e-14;

/// Damped Newton on one point, the cameras held. Returns the cost; `position` has a finite cost at the start.
double RefinePoint(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
                   std::size_t point, double huber_threshold, Eigen::Vector3d& position) {
  double damping = 1e-4;
  double cost = PointCost(pinhole, structure, state, point, position, huber_threshold);
  ObservationModel<3> model;
  for (int iteration = 0; iteration < kPointIterations; ++iteration) {
    Eigen::Matrix3d exact = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d safe = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (int k = structure.first_observation[point]; k < structure.first_observation[point + 1]; ++k) {
      const SolverObservation& seen = structure.observations[k];
      const Eigen::Matrix3d& R = state.rotations[seen.camera];
      const Eigen::Vector3d x_in_camera = R * (position - state.centres[seen.camera]);
      NewtonModel(pinhole, R, x_in_camera, seen.pixel, seen.inverse_sigma, huber_threshold, model);
      exact += model.hessian;
      GaussNewtonModel(pinhole, R, x_in_camera, seen.pixel, seen.inverse_sigma, huber_threshold, model);
      safe += model.hessian;
      gradient += model.gradient;
    }
    const Eigen::Matrix3d damped = exact + damping * Eigen::Matrix3d(safe.diagonal().asDiagonal());
    Eigen::LLT<Eigen::Matrix3d> factor(damped);
    if (factor.info() != Eigen::Success) {
      factor.compute(safe + damping * Eigen::Matrix3d(safe.diagonal().asDiagonal()));
      if (factor.info() != Eigen::Success) return cost;
    }
    const Eigen::Vector3d move = factor.solve(gradient);
    const double moved_cost = PointCost(pinhole, structure, state, point, position - move, huber_threshold);
    if (moved_cost < cost) {
      const double gained = cost - moved_cost;
      position -= move;
      cost = moved_cost;
      damping = 0.1 * damping;
      if (gained < kSettled * cost) return cost;
    } else {
      damping = 10 * damping;
    }
  }
  return cost;
}

/// Where a point comes to be that goes along with the camera it is closest in front of, and so stays there.
Eigen::Vector3d CarriedPoint(const BundleStructure& structure, const BundleState& state, const BundleState& trial,
                             std::size_t point) {
  Eigen::Vector3d carried = state.points[point];
  double least_depth = kInfinity;
  for (int k = structure.first_observation[point]; k < structure.first_observation[point + 1]; ++k) {
    const int camera = structure.observations[k].camera;
    const Eigen::Vector3d x_in_camera = state.rotations[camera] * (state.points[point] - state.centres[camera]);
    if (x_in_camera.z() >= least_depth) continue;
    least_depth = x_in_camera.z();
    carried = trial.rotations[camera].transpose() * x_in_camera + trial.centres[camera];
  }
  return carried;
}

/// A point's cost has to rise by this much (sigmas squared) before it is looked at on its own.
constexpr double kNoticeableRise = 0.1;

template <int kDof>
double PlacePoint(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
                  const NormalEquations<kDof>& equations, const KktStep& step, double huber_threshold,
                  std::size_t point, BundleState& trial) {
  Eigen::Vector3d& position = trial.points[point];
  position = state.points[point] + step.points[point];
  double cost = PointCost(pinhole, structure, trial, point, position, huber_threshold);
  const bool as_expected = cost <= equations.point_cost[point] + kNoticeableRise;
  if (as_expected && !equations.point_is_rough[point]) return cost;
  for (const Eigen::Vector3d& other : {state.points[point], CarriedPoint(structure, state, trial, point)}) {
    const double other_cost = PointCost(pinhole, structure, trial, point, other, huber_threshold);
    if (cost <= other_cost) continue;
    position = other;
    cost = other_cost;
  }
  if (!(cost < kInfinity)) return kInfinity;
  return RefinePoint(pinhole, structure, trial, point, huber_threshold, position);
}

}  // namespace

template <int kDof>
ConstraintMatrix ConstraintGradients(const BundleProblem& problem, const BundleStructure& structure,
                                     const std::vector<LinearizedDistance>& constraints) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int camera, std::size_t constraint, const Eigen::Vector3d& gradient) {
    const int column = structure.column_of_camera[camera];
    if (column < 0) return;
    // The unknown is delta, with the centre at c - delta.
    for (int k = 0; k < 3; ++k)
      entries.emplace_back(kDof * column + kDof - 3 + k, static_cast<int>(constraint), -gradient[k]);
  };
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    add(problem.distances[i].camera_a, i, constraints[i].gradient);
    add(problem.distances[i].camera_b, i, -constraints[i].gradient);
  }
  ConstraintMatrix gradients(kDof * static_cast<Eigen::Index>(structure.camera_of_column.size()),
                             static_cast<Eigen::Index>(constraints.size()));
  gradients.setFromTriplets(entries.begin(), entries.end());
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
              const std::vector<LinearizedDistance>& constraints, const ConstraintMatrix& constraint_gradients,
              double share, SchurSystem<kDof>& system, CameraSolver<kDof>& solver, KktStep& step) {
  const Eigen::Index count = static_cast<Eigen::Index>(constraints.size());
  Augment(problem, structure, constraints, constraint_gradients, share, system);
  if (!solver.Factorize(system.blocks, constraint_gradients)) return false;
  Eigen::VectorXd values(count);
  for (Eigen::Index i = 0; i < count; ++i) values[i] = share * constraints[static_cast<std::size_t>(i)].value;
  solver.Solve(-system.gradient, -values, step.cameras, step.multipliers);
  BackSubstitute(structure, equations, system, step.cameras, step.points);
  if (!step.cameras.allFinite()) return false;

  // The step's own equation gives the curvature along it: step^T (H + damping) step = -slope + multipliers^T values.
  double slope = 0;
  double damped = system.damping.dot(step.cameras.cwiseAbs2());
  for (std::size_t i = 0; i < equations.camera_gradient.size(); ++i) {
    const Eigen::Index row = kDof * static_cast<Eigen::Index>(i);
    slope += equations.camera_gradient[i].dot(step.cameras.template segment<kDof>(row));
  }
  for (std::size_t i = 0; i < equations.point_gradient.size(); ++i) {
    slope += equations.point_gradient[i].dot(step.points[i]);
    damped += system.point_damping[i].dot(step.points[i].cwiseAbs2());
  }
  const double curvature = -slope + step.multipliers.dot(values) - damped;
  step.predicted_decrease = -slope - 0.5 * curvature;
  return true;
}

template <int kDof>
double KktResidual(const NormalEquations<kDof>& equations, const ConstraintMatrix& constraint_gradients,
                   const Eigen::VectorXd& multipliers) {
  using CameraVector = typename NormalEquations<kDof>::CameraVector;
  CameraVector mean = CameraVector::Zero();
  for (const auto& hessian : equations.camera_hessian) mean += hessian.diagonal().cwiseAbs();
  mean /= std::max<double>(1.0, static_cast<double>(equations.camera_hessian.size()));
  const auto scaled = [](double gradient, double curvature, double stand_in) {
    const double weight = curvature != 0 ? std::abs(curvature) : stand_in;
    return weight > 0 ? std::abs(gradient) / std::sqrt(weight) : std::abs(gradient);
  };
  const Eigen::VectorXd reaction = constraint_gradients * multipliers;
  double largest = 0;
  for (std::size_t i = 0; i < equations.camera_gradient.size(); ++i) {
    CameraVector gradient = equations.camera_gradient[i];
    const Eigen::Index row = kDof * static_cast<Eigen::Index>(i);
    gradient += reaction.template segment<kDof>(row);
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
  template ConstraintMatrix ConstraintGradients<kDof>(const BundleProblem&, const BundleStructure&,          \
                                                      const std::vector<LinearizedDistance>&);               \
  template void AddConstraintCurvature<kDof>(const BundleProblem&, const BundleStructure&,                   \
                                             const std::vector<LinearizedDistance>&, const Eigen::VectorXd&, \
                                             SchurSystem<kDof>&);                                            \
  template bool SolveKkt<kDof>(const BundleProblem&, const BundleStructure&, const NormalEquations<kDof>&,   \
                               const std::vector<LinearizedDistance>&, const ConstraintMatrix&, double,      \
                               SchurSystem<kDof>&, CameraSolver<kDof>&, KktStep&);                           \
  template double KktResidual<kDof>(const NormalEquations<kDof>&, const ConstraintMatrix&, const Eigen::VectorXd&)
TURNSCALE_INSTANTIATE(3);
TURNSCALE_INSTANTIATE(6);
#undef TURNSCALE_INSTANTIATE

template <int kDof>
double TakeStep(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
                const NormalEquations<kDof>& equations, const KktStep& step, double huber_threshold,
                BundleState& trial) {
  trial.rotations = state.rotations;
  trial.centres = state.centres;
  trial.points = state.points;
  for (std::size_t i = 0; i < structure.camera_of_column.size(); ++i) {
    const int camera = structure.camera_of_column[i];
    const Eigen::Index row = kDof * static_cast<Eigen::Index>(i);
    trial.centres[camera] -= step.cameras.segment<3>(row + kDof - 3);
    if constexpr (kDof == 6) {
      const Eigen::Quaterniond turned =
          RotationFromVector(step.cameras.segment<3>(row)) * Eigen::Quaterniond(state.rotations[camera]);
      trial.rotations[camera] = turned.normalized().toRotationMatrix();
    }
  }
  std::vector<double> costs(state.points.size());
  ForEachPart(PartsOf(costs.size()), [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i)
      costs[i] = PlacePoint(pinhole, structure, state, equations, step, huber_threshold, i, trial);
  });
  const double cost = std::accumulate(costs.begin(), costs.end(), 0.0);
  return cost < kInfinity ? cost : kInfinity;
}

template double TakeStep<3>(const Pinhole&, const BundleStructure&, const BundleState&, const NormalEquations<3>&,
                            const KktStep&, double, BundleState&);
template double TakeStep<6>(const Pinhole&, const BundleStructure&, const BundleState&, const NormalEquations<6>&,
                            const KktStep&, double, BundleState&);

}  // namespace turnscale
