// SPDX-License-Identifier: MIT
#include "turnscale/bundle/camera_solver.h"

#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace turnscale {
namespace {

/// A banded system with one far corner, as a drive that comes back to its start.
template <int kDof>
struct Banded {
  Banded(int columns, int band) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (int i = 0; i < columns; ++i) pattern.push_back({i, i});
    for (int i = 0; i < columns; ++i) {
      for (int j = i + 1; j < std::min(columns, i + band); ++j) pattern.push_back({i, j});
      if (i == 0 && band < columns) pattern.push_back({0, columns - 1});
    }
    matrix.setZero(columns * kDof, columns * kDof);
    for (const auto& [row, column] : pattern) {
      Eigen::Matrix<double, kDof, kDof> block;
      for (double& entry : block.reshaped()) entry = normal(random);
      if (row == column) {
        block = (block + block.transpose()).eval();
        block.diagonal().array() += 20.0 * band;
      }
      blocks.push_back(block);
      matrix.template block<kDof, kDof>(row * kDof, column * kDof) = block;
      matrix.template block<kDof, kDof>(column * kDof, row * kDof) = block.transpose();
    }
  }

  std::vector<std::array<int, 2>> pattern;
  std::vector<Eigen::Matrix<double, kDof, kDof>> blocks;
  Eigen::MatrixXd matrix;
};

/// As many constraints as columns: between neighbours, the first between the first column and what is fixed.
template <int kDof>
ConstraintMatrix ChainOfConstraints(int columns) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < columns; ++i) {
    for (const int column : {i - 1, i})
      for (int k = 0; column >= 0 && k < 3; ++k) entries.emplace_back(kDof * (column + 1) - 3 + k, i, normal(random));
  }
  ConstraintMatrix constraints(kDof * columns, columns);
  constraints.setFromTriplets(entries.begin(), entries.end());
  return constraints;
}

template <int kDof>
void ExpectSolves(int columns, int band) {
  Banded<kDof> system(columns, band);
  const Eigen::Index size = Eigen::Index{columns} * kDof;
  for (const bool constrained : {false, true}) {
    const ConstraintMatrix constraints = constrained ? ChainOfConstraints<kDof>(columns) : ConstraintMatrix(size, 0);
    const Eigen::Index count = constraints.cols();
    Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(size + count, size + count);
    kkt.topLeftCorner(size, size) = system.matrix;
    kkt.topRightCorner(size, count) = constraints;
    kkt.bottomLeftCorner(count, size) = kkt.topRightCorner(size, count).transpose();
    const Eigen::VectorXd right_hand_side = Eigen::VectorXd::Random(size + count);
    const Eigen::VectorXd expected = kkt.partialPivLu().solve(right_hand_side);
    CameraSolver<kDof> solver(columns, system.pattern, constraints);
    for (int repeat = 0; repeat < 2; ++repeat) {
      ASSERT_TRUE(solver.Factorize(system.blocks, constraints));
      Eigen::VectorXd cameras;
      Eigen::VectorXd multipliers;
      solver.Solve(right_hand_side.head(size), right_hand_side.tail(count), cameras, multipliers);
      EXPECT_LT((cameras - expected.head(size)).norm(), 1e-12 * expected.norm());
      EXPECT_LT((multipliers - expected.tail(count)).norm(), 1e-12 * expected.norm());
    }
    std::vector<typename CameraSolver<kDof>::Block> blocks = system.blocks;
    blocks[1] = -blocks[1];
    EXPECT_FALSE(solver.Factorize(blocks, constraints)) << "not positive definite";
  }
}

TEST(CameraSolver, SolvesSmallAndDenselyConnectedSystems) {
  ExpectSolves<6>(5, 5);
  ExpectSolves<3>(40, 40);
}

TEST(CameraSolver, SolvesLongDrives) {
  ExpectSolves<6>(50, 6);
  ExpectSolves<3>(80, 6);
}

TEST(CameraSolver, TakesAnHourWithEveryStepHeld) {
  constexpr int kColumns = 25'000;
  std::vector<std::array<int, 2>> pattern;
  std::vector<Eigen::Matrix3d> blocks;
  for (int i = 0; i < kColumns; ++i) {
    pattern.push_back({i, i});
    blocks.emplace_back(4 * Eigen::Matrix3d::Identity());
  }
  for (int i = 0; i + 1 < kColumns; ++i) {
    pattern.push_back({i, i + 1});
    blocks.emplace_back(-Eigen::Matrix3d::Identity());
  }
  // As dense matrices, the constraints would take 15 GB.
  const ConstraintMatrix constraints = ChainOfConstraints<3>(kColumns);
  CameraSolver<3> solver(kColumns, pattern, constraints);
  ASSERT_TRUE(solver.Factorize(blocks, constraints));
  const Eigen::VectorXd right_hand_side = Eigen::VectorXd::Random(3 * kColumns);
  const Eigen::VectorXd constraint_side = Eigen::VectorXd::Random(kColumns);
  Eigen::VectorXd cameras;
  Eigen::VectorXd multipliers;
  solver.Solve(right_hand_side, constraint_side, cameras, multipliers);
  EXPECT_LT((constraints.transpose() * cameras - constraint_side).norm(), 1e-9 * constraint_side.norm());
  Eigen::VectorXd residual = 4 * cameras - right_hand_side + constraints * multipliers;
  residual.head(3 * (kColumns - 1)) -= cameras.tail(3 * (kColumns - 1));
  residual.tail(3 * (kColumns - 1)) -= cameras.head(3 * (kColumns - 1));
  EXPECT_LT(residual.norm(), 1e-9 * right_hand_side.norm());
}

}  // namespace
}  // namespace turnscale
