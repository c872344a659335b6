// SPDX-License-Identifier: MIT
#include "turnscale/bundle/kkt_step.h"

#include <algorithm>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "turnscale/bundle/reprojection.h"
#include "turnscale/bundle/synthetic_drive.h"

namespace turnscale {
namespace {

constexpr double kHuberThreshold = 1.5;
constexpr double kShare = 0.75;

/// A small problem with every special case of the block structure: two fixed cameras (one in the middle), a point seen
/// twice by one camera, a constraint with a fixed end.
BundleProblem SmallProblem() {
  SyntheticDriveOptions options;
  options.cameras = 7;
  options.points = 30;
  options.observations = 130;
  options.turn_every = 4;
  options.turn_length = 3;
  BundleProblem problem = MakeSyntheticDrive(options).truth;
  Disturb(0.004, 0.0004, 0.01, 9, problem);
  // Far too far away: a point whose exact Hessian is not positive definite.
  problem.points[3] *= 2.0;
  problem.camera_is_fixed[3] = 1;
  BundleObservation again = problem.observations[5];
  again.pixel += Eigen::Vector2d(0.4, -0.3);
  again.sigma = 2;
  problem.observations.push_back(again);
  problem.distances = {{4, 5, 1.02}, {3, 2, 0.97}, {6, 1, 4.0}};
  return problem;
}

/// The whole system as one dense matrix: cameras by column, then points.
template <int kDof>
struct DenseSystem {
  DenseSystem(const BundleProblem& problem, const BundleState& state, HessianKind kind,
              const std::vector<char>& is_rough, const BundleStructure& structure) {
    const int cameras = kDof * static_cast<int>(structure.camera_of_column.size());
    const int size = cameras + 3 * static_cast<int>(problem.points.size());
    hessian.setZero(size, size);
    gradient.setZero(size);
    for (const BundleObservation& seen : problem.observations) {
      const Eigen::Matrix3d& R = state.rotations[seen.camera];
      const Eigen::Vector3d x = R * (state.points[seen.point] - state.centres[seen.camera]);
      ObservationModel<kDof> model;
      if (kind == HessianKind::kNewton && !is_rough[seen.point]) {
        NewtonModel(problem.pinhole, R, x, seen.pixel, 1 / seen.sigma, kHuberThreshold, model);
      } else {
        GaussNewtonModel(problem.pinhole, R, x, seen.pixel, 1 / seen.sigma, kHuberThreshold, model);
      }
      // All unknowns enter through the model's variables: the step is E times the unknowns' step.
      Eigen::MatrixXd E = Eigen::MatrixXd::Zero(kDof, size);
      const Eigen::Index column = structure.column_of_camera[seen.camera];
      if (column >= 0) E.middleCols(kDof * column, kDof).setIdentity();
      E.block<3, 3>(kDof - 3, cameras + 3 * seen.point).setIdentity();
      hessian += E.transpose() * model.hessian * E;
      gradient += E.transpose() * model.gradient;
    }
  }

  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
};

template <int kDof>
void ExpectStepOfDenseSystem(bool constrained, double damping, HessianKind kind) {
  BundleProblem problem = SmallProblem();
  if (!constrained) problem.distances.clear();
  const BundleState state = StateFromProblem(problem);
  const BundleStructure structure = MakeStructure(problem, state);
  NormalEquations<kDof> equations;
  Linearize(problem.pinhole, structure, state, kHuberThreshold, kind, equations);
  const auto rough_points = std::count(equations.point_is_rough.begin(), equations.point_is_rough.end(), 1);
  ASSERT_EQ(rough_points > 0, kind == HessianKind::kNewton) << "both kinds of points are wanted in one system";
  ASSERT_LT(rough_points, 10);

  std::vector<LinearizedDistance> constraints;
  for (const DistanceConstraint& held : problem.distances) {
    constraints.push_back(LinearizeDistance(held, state.centres));
  }
  const ConstraintMatrix D = ConstraintGradients<kDof>(problem, structure, constraints);
  CameraSolver<kDof> solver(static_cast<int>(structure.camera_of_column.size()), structure.blocks, D);
  SchurSystem<kDof> system;
  Eliminate(structure, equations, damping, system);
  const Eigen::VectorXd old_multipliers = 10.0 * Eigen::VectorXd::Ones(constraints.size());
  AddConstraintCurvature(problem, structure, constraints, old_multipliers, system);
  KktStep step;
  ASSERT_TRUE(SolveKkt(problem, structure, equations, constraints, D, kShare, system, solver, step));

  const DenseSystem<kDof> dense(problem, state, kind, equations.point_is_rough, structure);
  const Eigen::Index size = dense.gradient.size();
  const Eigen::Index count = static_cast<Eigen::Index>(constraints.size());
  Eigen::MatrixXd undamped = dense.hessian;
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(size + count, size + count);
  Eigen::VectorXd right_hand_side(size + count);
  right_hand_side.head(size) = -dense.gradient;
  for (Eigen::Index i = 0; i < count; ++i) {
    const DistanceConstraint& held = problem.distances[i];
    right_hand_side[size + i] = -kShare * constraints[i].value;
    kkt.block(0, size + i, D.rows(), 1) = Eigen::VectorXd(D.col(i));
    kkt.block(size + i, 0, 1, D.rows()) = Eigen::VectorXd(D.col(i)).transpose();
    for (const int row : {held.camera_a, held.camera_b}) {
      for (const int column : {held.camera_a, held.camera_b}) {
        const int r = structure.column_of_camera[row];
        const int c = structure.column_of_camera[column];
        if (r < 0 || c < 0) continue;
        undamped.block<3, 3>(kDof * r + kDof - 3, kDof * c + kDof - 3) +=
            (row == column ? 1.0 : -1.0) * old_multipliers[i] * constraints[i].curvature;
      }
    }
  }
  kkt.topLeftCorner(size, size) = undamped;
  kkt.diagonal().head(size) += damping * dense.hessian.diagonal();
  const Eigen::VectorXd expected = kkt.fullPivLu().solve(right_hand_side);

  const Eigen::VectorXd expected_step = expected.head(size);
  Eigen::VectorXd actual(size);
  actual.head(step.cameras.size()) = step.cameras;
  for (std::size_t i = 0; i < step.points.size(); ++i) {
    actual.segment<3>(step.cameras.size() + 3 * static_cast<Eigen::Index>(i)) = step.points[i];
  }
  EXPECT_LT((actual - expected_step).norm(), 1e-9 * expected_step.norm());
  EXPECT_LT((step.multipliers - expected.tail(count)).norm(), 1e-8 * (1 + expected.tail(count).norm()));
  const double slope = dense.gradient.dot(expected_step);
  const double decrease = -slope - 0.5 * expected_step.dot(undamped * expected_step);
  EXPECT_NEAR(step.predicted_decrease, decrease, 1e-8 * std::abs(slope));

  Eigen::VectorXd lagrangian = dense.gradient;
  lagrangian.head(D.rows()) += D * step.multipliers;
  const Eigen::VectorXd deviations = dense.hessian.diagonal().cwiseSqrt();
  const double residual = lagrangian.cwiseQuotient(deviations).cwiseAbs().maxCoeff();
  EXPECT_NEAR(KktResidual(equations, D, step.multipliers), residual, 1e-9 * residual);
}

TEST(KktStep, IsTheStepOfTheWholeSystem) {
  for (const HessianKind kind : {HessianKind::kGaussNewton, HessianKind::kNewton}) {
    for (const bool constrained : {false, true}) {
      ExpectStepOfDenseSystem<3>(constrained, 1e-2, kind);
      ExpectStepOfDenseSystem<6>(constrained, 1e-2, kind);
      ExpectStepOfDenseSystem<3>(constrained, 1e-9, kind);
    }
  }
}

TEST(KktStep, ConstraintsAloneMayHoldTheScale) {
  // One fixed camera: without the constraints the reduced matrix is singular along the scale.
  SyntheticDriveOptions options;
  options.cameras = 5;
  options.points = 40;
  options.observations = 180;
  options.pixel_noise = 0;
  BundleProblem problem = MakeSyntheticDrive(options).truth;
  problem.distances = {{1, 2, 1.1}};
  const BundleState state = StateFromProblem(problem);
  const BundleStructure structure = MakeStructure(problem, state);
  NormalEquations<3> equations;
  Linearize(problem.pinhole, structure, state, kHuberThreshold, HessianKind::kGaussNewton, equations);
  const std::vector<LinearizedDistance> constraints = {LinearizeDistance(problem.distances[0], state.centres)};
  const ConstraintMatrix D = ConstraintGradients<3>(problem, structure, constraints);
  CameraSolver<3> solver(4, structure.blocks, D);
  SchurSystem<3> system;
  Eliminate(structure, equations, 1e-14, system);
  KktStep step;
  ASSERT_TRUE(SolveKkt(problem, structure, equations, constraints, D, 1.0, system, solver, step));
  const double actual = (state.centres[1] - state.centres[2]).norm();
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Eigen::Vector3d scaled = (1.1 / actual) * state.centres[i + 1];
    EXPECT_LT((state.centres[i + 1] - step.cameras.segment<3>(3 * i) - scaled).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace turnscale
