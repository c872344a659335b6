// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace turnscale {

/// Cholesky factorisation of the reduced camera system. Small or densely connected systems are factorised as dense
/// matrices, long drives as sparse ones with a fill-reducing order that is found once.
template <int kDof>
class CameraSolver {
 public:
  using Block = Eigen::Matrix<double, kDof, kDof>;

  /// `pattern`: (row, column) of the blocks on and above the diagonal; the diagonal first, then by row and column.
  CameraSolver(int columns, const std::vector<std::array<int, 2>>& pattern);

  /// False where the matrix is not positive definite; the solver is then not to be used until the next success.
  bool Factorize(const std::vector<Block>& blocks);

  /// S^-1 times the right-hand sides (one a column), in two halves: S = F F^T, and SolveLower gives F^-1 times them, of
  /// which SolveUpper makes F^-T F^-1.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right_hand_sides) const {
    return SolveUpper(SolveLower(right_hand_sides));
  }
  Eigen::MatrixXd SolveLower(const Eigen::MatrixXd& right_hand_sides) const;
  Eigen::MatrixXd SolveUpper(Eigen::MatrixXd half_solved) const;

  bool is_dense() const { return is_dense_; }

 private:
  void MakeSparsePattern();

  int columns_;
  std::vector<std::array<int, 2>> pattern_;
  bool is_dense_;
  Eigen::MatrixXd matrix_;
  Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> dense_;
  std::vector<int> place_;                     ///< of each column in the fill-reducing order
  Eigen::SparseMatrix<double> sparse_matrix_;  ///< lower triangle, in that order
  std::vector<std::array<int, kDof>> value_;   ///< where a block's share of each matrix column starts in the values
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>> sparse_;
};

}  // namespace turnscale
