// SPDX-License-Identifier: MIT
#include "turnscale/bundle/trial.h"

#include <cstddef>
#include <limits>

#include <Eigen/Cholesky>

#include "turnscale/bundle/reprojection.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

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
  double cost = 0;
  for (std::size_t i = 0; i < state.points.size(); ++i) {
    cost += PlacePoint(pinhole, structure, state, equations, step, huber_threshold, i, trial);
    if (!(cost < kInfinity)) return kInfinity;
  }
  return cost;
}

template double TakeStep<3>(const Pinhole&, const BundleStructure&, const BundleState&, const NormalEquations<3>&,
                            const KktStep&, double, BundleState&);
template double TakeStep<6>(const Pinhole&, const BundleStructure&, const BundleState&, const NormalEquations<6>&,
                            const KktStep&, double, BundleState&);

}  // namespace turnscale
