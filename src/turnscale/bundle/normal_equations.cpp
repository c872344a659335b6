// SPDX-License-Identifier: MIT
#include "turnscale/bundle/normal_equations.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Cholesky>

#include "turnscale/bundle/parts.h"
#include "turnscale/bundle/reprojection.h"

namespace turnscale {
namespace {

/// Makes room, and clears the sums. What belongs to a point or an edge is going to be overwritten.
template <int kDof>
void Prepare(const BundleStructure& structure, std::size_t points, NormalEquations<kDof>& equations) {
  using Equations = NormalEquations<kDof>;
  equations.camera_hessian.assign(structure.camera_of_column.size(), Equations::CameraMatrix::Zero());
  equations.camera_gradient.assign(structure.camera_of_column.size(), Equations::CameraVector::Zero());
  equations.edge_hessian.resize(structure.edge_column.size());
  equations.point_hessian.resize(points);
  equations.point_gradient.resize(points);
  equations.point_cost.resize(points);
  equations.point_is_rough.resize(points);
  equations.cost = 0;
}

/// Whether a point's exact Hessian keeps at least this share of Gauss-Newton's in every direction, cameras held.
constexpr double kSafeShare = 0.02;

/// A point's observations in camera axes.
struct PointView {
  Eigen::Vector3d x_in_camera;
  CameraAxesModel model;
};

/// Fills the views of a point and says whether its exact Hessian is safe.
bool NewtonIsSafe(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
                  double huber_threshold, std::size_t point, std::vector<PointView>& views) {
  views.clear();
  Eigen::Matrix3d difference = Eigen::Matrix3d::Zero();
  for (int k = structure.first_observation[point]; k < structure.first_observation[point + 1]; ++k) {
    const SolverObservation& seen = structure.observations[k];
    const Eigen::Matrix3d& R = state.rotations[seen.camera];
    PointView view;
    view.x_in_camera = R * (state.points[point] - state.centres[seen.camera]);
    view.model = ModelInCameraAxes(pinhole, view.x_in_camera, seen.pixel, seen.inverse_sigma, huber_threshold);
    const Eigen::Matrix3d above = view.model.newton - kSafeShare * view.model.gauss_newton;
    difference += R.transpose() * (above * R);
    views.push_back(view);
  }
  return Eigen::LLT<Eigen::Matrix3d>(difference).info() == Eigen::Success;
}

/// Fills in points `first` to `last`, and sums up what they add to the cameras.
template <int kDof>
void LinearizePoints(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
                     double huber_threshold, HessianKind kind, std::size_t first, std::size_t last,
                     CameraSums<kDof>& sums, NormalEquations<kDof>& equations) {
  using Equations = NormalEquations<kDof>;
  sums.hessian.assign(structure.camera_of_column.size(), Equations::CameraMatrix::Zero());
  sums.gradient.assign(structure.camera_of_column.size(), Equations::CameraVector::Zero());
  ObservationModel<kDof> model;
  std::vector<PointView> views;
  for (std::size_t i = first; i < last; ++i) {
    const bool newton =
        kind == HessianKind::kNewton && NewtonIsSafe(pinhole, structure, state, huber_threshold, i, views);
    equations.point_is_rough[i] = kind == HessianKind::kNewton && !newton;
    double point_cost = 0;
    Eigen::Matrix3d point_hessian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d point_gradient = Eigen::Vector3d::Zero();
    int last_edge = -1;
    for (int k = structure.first_observation[i]; k < structure.first_observation[i + 1]; ++k) {
      const SolverObservation& seen = structure.observations[k];
      const Eigen::Matrix3d& R = state.rotations[seen.camera];
      if (newton) {
        const PointView& view = views[k - structure.first_observation[i]];
        ExpandNewton(view.model, R, view.x_in_camera, model);
        point_cost += view.model.cost;
      } else {
        const Eigen::Vector3d x_in_camera = R * (state.points[i] - state.centres[seen.camera]);
        point_cost += GaussNewtonModel(pinhole, R, x_in_camera, seen.pixel, seen.inverse_sigma, huber_threshold, model);
      }
      point_hessian += model.hessian.template bottomRightCorner<3, 3>();
      point_gradient += model.gradient.template tail<3>();
      if (seen.edge < 0) continue;
      const int column = structure.edge_column[seen.edge];
      sums.hessian[column] += model.hessian;
      sums.gradient[column] += model.gradient;
      // A camera that sees the point twice has both in one edge, one after the other.
      if (seen.edge == last_edge)
        equations.edge_hessian[seen.edge] += model.hessian.template rightCols<3>();
      else
        equations.edge_hessian[seen.edge] = model.hessian.template rightCols<3>();
      last_edge = seen.edge;
    }
    equations.point_cost[i] = point_cost;
    equations.point_hessian[i] = point_hessian;
    equations.point_gradient[i] = point_gradient;
  }
}

/// A pivot below this share of its diagonal entry is nothing but rounding.
constexpr double kPivotRounding = 1e-14;

/// Lower-triangular F with F V F^T = I. A pivot that is rounding gives a row of zeros: no step along it.
Eigen::Matrix3d InverseFactor(const Eigen::Matrix3d& V) {
  const auto inverse_root = [](double pivot, double diagonal) {
    return pivot > kPivotRounding * diagonal ? 1.0 / std::sqrt(pivot) : 0.0;
  };
  // V = L L^T with the inverses of L's diagonal at hand.
  const double i0 = inverse_root(V(0, 0), V(0, 0));
  const double l10 = V(1, 0) * i0;
  const double l20 = V(2, 0) * i0;
  const double i1 = inverse_root(V(1, 1) - l10 * l10, V(1, 1));
  const double l21 = (V(2, 1) - l20 * l10) * i1;
  const double i2 = inverse_root(V(2, 2) - l20 * l20 - l21 * l21, V(2, 2));
  Eigen::Matrix3d F = Eigen::Matrix3d::Zero();
  F(0, 0) = i0;
  F(1, 1) = i1;
  F(2, 2) = i2;
  F(1, 0) = -l10 * i0 * i1;
  F(2, 1) = -l21 * i1 * i2;
  F(2, 0) = -(l20 * i0 + l21 * F(1, 0)) * i2;
  return F;
}

/// Damping of the cameras: a share of the diagonal, for a parameter that no observation touches a share of the other
/// cameras' mean. So it stays where it is unless a constraint moves it.
template <int kDof>
Eigen::VectorXd CameraDamping(const NormalEquations<kDof>& equations, double damping) {
  using CameraVector = typename NormalEquations<kDof>::CameraVector;
  CameraVector mean = CameraVector::Zero();
  for (const auto& hessian : equations.camera_hessian) mean += hessian.diagonal().cwiseAbs();
  mean /= static_cast<double>(equations.camera_hessian.size());
  Eigen::VectorXd added(kDof * static_cast<Eigen::Index>(equations.camera_hessian.size()));
  for (std::size_t i = 0; i < equations.camera_hessian.size(); ++i) {
    for (int k = 0; k < kDof; ++k) {
      const double diagonal = std::abs(equations.camera_hessian[i](k, k));
      added[static_cast<Eigen::Index>(i) * kDof + k] =
          damping * (diagonal > 0 ? diagonal : (mean[k] > 0 ? mean[k] : 1.0));
    }
  }
  return added;
}

/// block += a b^T, a column at a time: each entry of b is read once.
template <int kDof>
void AddOuterProduct(const Eigen::Matrix<double, kDof, 3>& a, const Eigen::Matrix<double, kDof, 3>& b,
                     Eigen::Matrix<double, kDof, kDof>& block) {
  for (int column = 0; column < kDof; ++column) {
    block.col(column) += a.col(0) * b(column, 0) + a.col(1) * b(column, 1) + a.col(2) * b(column, 2);
  }
}

/// Eliminates points `first` to `last`, and sums up what that takes from the cameras.
template <int kDof>
void EliminatePoints(const BundleStructure& structure, const NormalEquations<kDof>& equations, double damping,
                     std::size_t first, std::size_t last, SchurPart<kDof>& part, SchurSystem<kDof>& system) {
  part.blocks.assign(structure.blocks.size(), Eigen::Matrix<double, kDof, kDof>::Zero());
  part.gradient.setZero(system.gradient.size());
  part.track.resize(structure.longest_track);
  const int* block = structure.pair_block.data() + structure.first_pair[first];
  for (std::size_t i = first; i < last; ++i) {
    Eigen::Matrix3d V = equations.point_hessian[i];
    system.point_damping[i] = damping * V.diagonal();
    V.diagonal() += system.point_damping[i];
    const Eigen::Matrix3d F = InverseFactor(V);
    system.inverse_factor[i] = F;
    const Eigen::Vector3d reduced = F * equations.point_gradient[i];
    const int first_edge = structure.first_edge[i];
    const int edges = structure.first_edge[i + 1] - first_edge;
    for (int a = 0; a < edges; ++a) {
      part.track[a].noalias() = equations.edge_hessian[first_edge + a] * F.transpose();
      part.gradient.template segment<kDof>(kDof * structure.edge_column[first_edge + a]) += part.track[a] * reduced;
    }
    for (int a = 0; a < edges; ++a) {
      // A copy, which stays in registers: the blocks cannot overlap it.
      const Eigen::Matrix<double, kDof, 3> left = part.track[a];
      for (int b = a; b < edges; ++b) AddOuterProduct<kDof>(left, part.track[b], part.blocks[*block++]);
    }
  }
}

}  // namespace

template <int kDof>
void Linearize(const Pinhole& pinhole, const BundleStructure& structure, const BundleState& state,
               double huber_threshold, HessianKind kind, NormalEquations<kDof>& equations) {
  Prepare(structure, state.points.size(), equations);
  const std::vector<std::size_t> bounds = PartsOf(state.points.size());
  equations.parts.resize(bounds.size() - 1);
  ForEachPart(bounds, [&](std::size_t part, std::size_t first, std::size_t last) {
    LinearizePoints(pinhole, structure, state, huber_threshold, kind, first, last, equations.parts[part], equations);
  });
  for (const CameraSums<kDof>& sum : equations.parts) {
    for (std::size_t i = 0; i < sum.hessian.size(); ++i) {
      equations.camera_hessian[i] += sum.hessian[i];
      equations.camera_gradient[i] += sum.gradient[i];
    }
  }
  for (const double point_cost : equations.point_cost) equations.cost += point_cost;
}

template void Linearize<3>(const Pinhole&, const BundleStructure&, const BundleState&, double, HessianKind,
                           NormalEquations<3>&);
template void Linearize<6>(const Pinhole&, const BundleStructure&, const BundleState&, double, HessianKind,
                           NormalEquations<6>&);

template <int kDof>
void Eliminate(const BundleStructure& structure, const NormalEquations<kDof>& equations, double damping,
               SchurSystem<kDof>& system) {
  const std::size_t columns = equations.camera_hessian.size();
  const std::size_t points = equations.point_hessian.size();
  system.gradient.resize(kDof * static_cast<Eigen::Index>(columns));
  system.inverse_factor.resize(points);
  system.point_damping.resize(points);
  system.damping = CameraDamping(equations, damping);
  for (std::size_t i = 0; i < columns; ++i)
    system.gradient.template segment<kDof>(kDof * static_cast<Eigen::Index>(i)) = equations.camera_gradient[i];

  const std::vector<std::size_t> bounds = PartsOf(points);
  system.parts.resize(bounds.size() - 1);
  ForEachPart(bounds, [&](std::size_t part, std::size_t first, std::size_t last) {
    EliminatePoints(structure, equations, damping, first, last, system.parts[part], system);
  });
  for (const SchurPart<kDof>& part : system.parts) system.gradient -= part.gradient;
  // The first blocks are those of the diagonal.
  constexpr std::size_t kLeastBlocks = 400;
  system.blocks.resize(structure.blocks.size());
  ForEachPart(PartsOf(system.blocks.size(), kLeastBlocks), [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      if (i < columns) {
        system.blocks[i] = equations.camera_hessian[i];
        system.blocks[i].diagonal() += system.damping.template segment<kDof>(kDof * static_cast<Eigen::Index>(i));
      } else {
        system.blocks[i].setZero();
      }
      for (const SchurPart<kDof>& part : system.parts) system.blocks[i] -= part.blocks[i];
    }
  });
}

template <int kDof>
void AddToPair(const BundleStructure& structure, const DistanceConstraint& pair, int between, const Eigen::Matrix3d& M,
               SchurSystem<kDof>& system) {
  for (const int camera : {pair.camera_a, pair.camera_b}) {
    const int column = structure.column_of_camera[camera];
    if (column >= 0) system.blocks[column].template bottomRightCorner<3, 3>() += M;
  }
  if (between >= 0) system.blocks[between].template bottomRightCorner<3, 3>() -= M;
}

template <int kDof>
void BackSubstitute(const BundleStructure& structure, const NormalEquations<kDof>& equations,
                    const SchurSystem<kDof>& system, const Eigen::VectorXd& camera_step,
                    std::vector<Eigen::Vector3d>& point_step) {
  point_step.resize(equations.point_hessian.size());
  ForEachPart(PartsOf(point_step.size()), [&](std::size_t, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      Eigen::Vector3d gradient = equations.point_gradient[i];
      for (int k = structure.first_edge[i]; k < structure.first_edge[i + 1]; ++k) {
        gradient.noalias() +=
            equations.edge_hessian[k].transpose() * camera_step.template segment<kDof>(kDof * structure.edge_column[k]);
      }
      const Eigen::Matrix3d& F = system.inverse_factor[i];
      point_step[i] = -(F.transpose() * (F * gradient));
    }
  });
}

template void Eliminate<3>(const BundleStructure&, const NormalEquations<3>&, double, SchurSystem<3>&);
template void Eliminate<6>(const BundleStructure&, const NormalEquations<6>&, double, SchurSystem<6>&);
template void AddToPair<3>(const BundleStructure&, const DistanceConstraint&, int, const Eigen::Matrix3d&,
                           SchurSystem<3>&);
template void AddToPair<6>(const BundleStructure&, const DistanceConstraint&, int, const Eigen::Matrix3d&,
                           SchurSystem<6>&);
template void BackSubstitute<3>(const BundleStructure&, const NormalEquations<3>&, const SchurSystem<3>&,
                                const Eigen::VectorXd&, std::vector<Eigen::Vector3d>&);
template void BackSubstitute<6>(const BundleStructure&, const NormalEquations<6>&, const SchurSystem<6>&,
                                const Eigen::VectorXd&, std::vector<Eigen::Vector3d>&);

}  // namespace turnscale
