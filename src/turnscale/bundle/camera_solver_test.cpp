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

template <int kDof>
void ExpectSolves(int columns, int band, bool dense) {
  Banded<kDof> system(columns, band);
  CameraSolver<kDof> solver(columns, system.pattern);
  EXPECT_EQ(solver.is_dense(), dense);
  const Eigen::MatrixXd right_hand_sides = Eigen::MatrixXd::Random(columns * kDof, 2);
  for (int repeat = 0; repeat < 2; ++repeat) {
    ASSERT_TRUE(solver.Factorize(system.blocks));
    const Eigen::MatrixXd expected = system.matrix.partialPivLu().solve(right_hand_sides);
    EXPECT_LT((solver.Solve(right_hand_sides) - expected).norm(), 1e-12 * expected.norm());
  }
  system.blocks[1] = -system.blocks[1];
  EXPECT_FALSE(solver.Factorize(system.blocks)) << "not positive definite";
}

TEST(CameraSolver, SolvesSmallAndDenselyConnectedSystemsAsDenseOnes) {
  ExpectSolves<6>(5, 5, true);
  ExpectSolves<3>(40, 40, true);
}

TEST(CameraSolver, SolvesLongDrivesAsSparseOnes) {
  ExpectSolves<6>(50, 6, false);
  ExpectSolves<3>(80, 6, false);
}

}  // namespace
}  // namespace turnscale
