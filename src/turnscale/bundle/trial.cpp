// SPDX-License-Identifier: MIT
#include "turnscale/bundle/trial.h"

#include <cstddef>
#include <limits>

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

}  // namespace

template <int kDof>
double TakeStep(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state, const KktStep& step,
                double share, double huber_threshold, BundleState& trial) {
  trial.rotations = state.rotations;
  trial.centres = state.centres;
  trial.points = state.points;
  for (std::size_t i = 0; i < structure.camera_of_column.size(); ++i) {
    const int camera = structure.camera_of_column[i];
    const Eigen::Index row = kDof * static_cast<Eigen::Index>(i);
    trial.centres[camera] -= share * step.cameras.segment<3>(row + kDof - 3);
    if constexpr (kDof == 6) {
      const Eigen::Quaterniond turned =
          RotationFromVector(share * step.cameras.segment<3>(row)) * Eigen::Quaterniond(state.rotations[camera]);
      trial.rotations[camera] = turned.normalized().toRotationMatrix();
    }
  }
  double cost = 0;
  for (std::size_t i = 0; i < state.points.size(); ++i) {
    constexpr int kHalvings = 5;
    double point_share = share;
    double point_cost = kInfinity;
    for (int k = 0; k <= kHalvings && !(point_cost < kInfinity); ++k) {
      trial.points[i] = state.points[i] + point_share * step.points[i];
      point_cost = PointCost(pinhole, structure, trial, i, trial.points[i], huber_threshold);
      point_share = k + 1 < kHalvings ? 0.5 * point_share : 0.0;
    }
    cost += point_cost;
    if (!(cost < kInfinity)) return kInfinity;
  }
  return cost;
}

template double TakeStep<3>(const Pinhole&, const BundleStructure&, const BundleState&, const KktStep&, double, double,
                            BundleState&);
template double TakeStep<6>(const Pinhole&, const BundleStructure&, const BundleState&, const KktStep&, double, double,
                            BundleState&);

}  // namespace turnscale
