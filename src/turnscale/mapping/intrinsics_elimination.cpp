// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_elimination.h"

#include <utility>

#include <Eigen/Cholesky>

namespace turnscale {
namespace {

constexpr int kEntries = IntrinsicsChange::kEntries;
constexpr int kPoseDof = IntrinsicsRow::kPoseDof;
using PoseBlock = Eigen::Matrix<double, 3, kPoseDof>;

// Share of the largest pivot below which a point's depth is not determined.
constexpr double kLeastPivot = 1e-7;
// Relative; keeps a factorization from stopping at rounding errors.
constexpr double kRounding = 1e-13;

// How much each pose's unknowns change when the window grows about its first camera: along it nothing else changes.
Eigen::VectorXd Growth(const std::vector<RigidTransform>& camera_from_world) {
  Eigen::VectorXd growth = Eigen::VectorXd::Zero(kPoseDof * (static_cast<Eigen::Index>(camera_from_world.size()) - 1));
  const Eigen::Vector3d origin = camera_from_world.front().inverse().translation;
  for (size_t k = 1; k < camera_from_world.size(); ++k)
    growth.segment<3>(kPoseDof * (static_cast<Eigen::Index>(k) - 1) + 3) =
        origin - camera_from_world[k].inverse().translation;
  return growth;
}

// Solves for the poses with the unit of length held. Nothing where the points do not determine them.
class PoseSolver {
 public:
  PoseSolver(const ReducedSystem& system, const Eigen::VectorXd& growth) {
    Eigen::MatrixXd hessian = system.hessian.topLeftCorner(system.poses, system.poses).selfadjointView<Eigen::Upper>();
    const double travel = growth.squaredNorm();
    // As stiff as the others; what the gauge is held with changes nothing else.
    const double stiffness = growth.cwiseAbs2().dot(hessian.diagonal()) / travel;
    hessian += stiffness / travel * growth * growth.transpose();
    // Rotations and centres have different units.
    unit_ = hessian.diagonal().cwiseSqrt().cwiseInverse();
    hessian = unit_.asDiagonal() * hessian * unit_.asDiagonal();
    hessian.diagonal().array() += kRounding;
    if (travel > 0 && unit_.allFinite()) factor_.compute(hessian);
    solves_ = travel > 0 && unit_.allFinite() && factor_.info() == Eigen::Success;
  }

  bool solves() const { return solves_; }
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const {
    return unit_.asDiagonal() * factor_.solve(unit_.asDiagonal() * right);
  }

 private:
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::VectorXd unit_;
  bool solves_ = false;
};

}  // namespace

std::optional<EliminatedPoint> Eliminate(const std::vector<IntrinsicsRow>& rows, ReducedSystem& system) {
  if (rows.size() < IntrinsicsRow::kFewestOfPoint) return std::nullopt;
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  PointByIntrinsics by_intrinsics = PointByIntrinsics::Zero();
  for (const IntrinsicsRow& row : rows) {
    hessian += row.point().transpose() * row.point();
    gradient += row.point().transpose() * row.residual;
    by_intrinsics += row.point().transpose() * row.intrinsics;
  }
  const Eigen::LLT<Eigen::Matrix3d> factor(hessian);
  const Eigen::Vector3d pivots = factor.matrixLLT().diagonal();
  if (factor.info() != Eigen::Success || !(pivots.minCoeff() > kLeastPivot * pivots.maxCoeff())) return std::nullopt;
  // Solved by the lower factor alone, so that products of two halves are what elimination takes off.
  by_intrinsics = factor.matrixL().solve(by_intrinsics).eval();
  gradient = factor.matrixL().solve(gradient).eval();
  std::vector<EliminatedPoint::Edge> halves;
  const int last = system.poses;
  for (const IntrinsicsRow& row : rows) {
    system.hessian.bottomRightCorner<kEntries, kEntries>() += row.intrinsics.transpose() * row.intrinsics;
    system.gradient.tail<kEntries>() += row.intrinsics.transpose() * row.residual;
    if (row.column < 0) continue;
    const PoseBlock block = row.point().transpose() * row.pose;
    halves.push_back({row.column, factor.matrixL().solve(block)});
    const PoseBlock& half = halves.back().block;
    system.hessian.block<kPoseDof, kPoseDof>(row.column, row.column) += row.pose.transpose() * row.pose;
    system.hessian.block<kPoseDof, kEntries>(row.column, last) +=
        row.pose.transpose() * row.intrinsics - half.transpose() * by_intrinsics;
    system.gradient.segment<kPoseDof>(row.column) += row.pose.transpose() * row.residual - half.transpose() * gradient;
  }
  system.hessian.bottomRightCorner<kEntries, kEntries>() -= by_intrinsics.transpose() * by_intrinsics;
  system.gradient.tail<kEntries>() -= by_intrinsics.transpose() * gradient;
  // Rows come in the order of keyframes; two of the same keyframe share a block, which wants both their products.
  for (size_t i = 0; i < halves.size(); ++i)
    for (size_t j = 0; j < halves.size(); ++j)
      if (halves[i].column <= halves[j].column)
        system.hessian.block<kPoseDof, kPoseDof>(halves[i].column, halves[j].column) -=
            halves[i].block.transpose() * halves[j].block;
  EliminatedPoint point{factor.matrixU().solve(gradient), factor.matrixU().solve(by_intrinsics), std::move(halves)};
  for (EliminatedPoint::Edge& edge : point.edges) edge.block = factor.matrixU().solve(edge.block).eval();
  return point;
}

std::optional<MarginalIntrinsics> Marginalize(const ReducedSystem& system,
                                              const std::vector<std::optional<EliminatedPoint>>& points,
                                              const std::vector<RigidTransform>& camera_from_world) {
  const PoseSolver solver(system, Growth(camera_from_world));
  if (!solver.solves()) return std::nullopt;
  const Eigen::MatrixXd cross = system.hessian.topRightCorner(system.poses, kEntries);
  MarginalIntrinsics marginal;
  IntrinsicsResponse& response = marginal.response;
  response.poses = -solver.Solve(cross);
  response.pose_step = -solver.Solve(system.gradient.head(system.poses));
  marginal.information = system.hessian.bottomRightCorner<kEntries, kEntries>() + cross.transpose() * response.poses;
  marginal.information = 0.5 * (marginal.information + marginal.information.transpose()).eval();
  marginal.gradient = system.gradient.tail<kEntries>() + cross.transpose() * response.pose_step;
  if (!marginal.information.allFinite() || !marginal.gradient.allFinite()) return std::nullopt;

  response.points.assign(points.size(), PointByIntrinsics::Zero());
  response.point_step.assign(points.size(), Eigen::Vector3d::Zero());
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (!points[p]) continue;
    response.points[p] = -points[p]->by_intrinsics;
    response.point_step[p] = -points[p]->step;
    for (const EliminatedPoint::Edge& edge : points[p]->edges) {
      response.points[p] -= edge.block * response.poses.middleRows<kPoseDof>(edge.column);
      response.point_step[p] -= edge.block * response.pose_step.segment<kPoseDof>(edge.column);
    }
  }
  return marginal;
}

}  // namespace turnscale
