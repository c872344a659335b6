// SPDX-License-Identifier: MIT
#include "turnscale/bundle/normal_equations.h"

#include <cstddef>

#include <Eigen/Cholesky>

#include "turnscale/bundle/reprojection.h"

namespace turnscale {
namespace {

template <int kDof>
void Clear(const BundleStructure& structure, std::size_t points, NormalEquations<kDof>& equations) {
  using Equations = NormalEquations<kDof>;
  equations.camera_hessian.assign(structure.camera_of_column.size(), Equations::CameraMatrix::Zero());
  equations.camera_gradient.assign(structure.camera_of_column.size(), Equations::CameraVector::Zero());
  equations.edge_hessian.assign(structure.edge_column.size(), Equations::EdgeMatrix::Zero());
  equations.point_hessian.assign(points, Eigen::Matrix3d::Zero());
  equations.point_gradient.assign(points, Eigen::Vector3d::Zero());
  equations.point_cost.assign(points, 0.0);
  equations.point_is_rough.assign(points, 0);
  equations.cost = 0;
}

/// Whether a point's exact Hessian keeps at least this share of Gauss-Newton's in every direction, cameras held.
constexpr double kSafeShare = 0.02;

bool NewtonIsSafe(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
                  double huber_threshold, std::size_t point) {
  Eigen::Matrix3d difference = Eigen::Matrix3d::Zero();
  ObservationModel<3> model;
  for (int k = structure.first_observation[point]; k < structure.first_observation[point + 1]; ++k) {
    const SolverObservation& seen = structure.observations[k];
    const Eigen::Matrix3d& R = state.rotations[seen.camera];
    const Eigen::Vector3d x_in_camera = R * (state.points[point] - state.centres[seen.camera]);
    NewtonModel(pinhole, R, x_in_camera, seen.pixel, seen.inverse_sigma, huber_threshold, model);
    difference += model.hessian;
    GaussNewtonModel(pinhole, R, x_in_camera, seen.pixel, seen.inverse_sigma, huber_threshold, model);
    difference -= kSafeShare * model.hessian;
  }
  return Eigen::LLT<Eigen::Matrix3d>(difference).info() == Eigen::Success;
}

}  // namespace

template <int kDof>
void Linearize(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
               double huber_threshold, HessianKind kind, NormalEquations<kDof>& equations) {
  Clear(structure, state.points.size(), equations);
  ObservationModel<kDof> model;
  for (std::size_t i = 0; i < state.points.size(); ++i) {
    const bool newton = kind == HessianKind::kNewton && NewtonIsSafe(pinhole, structure, state, huber_threshold, i);
    equations.point_is_rough[i] = kind == HessianKind::kNewton && !newton;
    double point_cost = 0;
    Eigen::Matrix3d point_hessian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d point_gradient = Eigen::Vector3d::Zero();
    for (int k = structure.first_observation[i]; k < structure.first_observation[i + 1]; ++k) {
      const SolverObservation& seen = structure.observations[k];
      const Eigen::Matrix3d& R = state.rotations[seen.camera];
      const Eigen::Vector3d x_in_camera = R * (state.points[i] - state.centres[seen.camera]);
      point_cost +=
          newton ? NewtonModel(pinhole, R, x_in_camera, seen.pixel, seen.inverse_sigma, huber_threshold, model)
                 : GaussNewtonModel(pinhole, R, x_in_camera, seen.pixel, seen.inverse_sigma, huber_threshold, model);
      point_hessian += model.hessian.template bottomRightCorner<3, 3>();
      point_gradient += model.gradient.template tail<3>();
      if (seen.edge < 0) continue;
      const int column = structure.edge_column[seen.edge];
      equations.camera_hessian[column] += model.hessian;
      equations.camera_gradient[column] += model.gradient;
      equations.edge_hessian[seen.edge] += model.hessian.template rightCols<3>();
    }
    equations.cost += point_cost;
    equations.point_cost[i] = point_cost;
    equations.point_hessian[i] = point_hessian;
    equations.point_gradient[i] = point_gradient;
  }
}

template void Linearize<3>(const Pinhole&, const BundleStructure&, const BundleState&, double, HessianKind,
                           NormalEquations<3>&);
template void Linearize<6>(const Pinhole&, const BundleStructure&, const BundleState&, double, HessianKind,
                           NormalEquations<6>&);

}  // namespace turnscale
