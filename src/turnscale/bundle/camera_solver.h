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

/// Gradients of the constraints, one column each, by the camera unknowns: each has entries for its two cameras.
using ConstraintMatrix = Eigen::SparseMatrix<double>;

/// Factorisation of the reduced camera system S, bordered by constraints: [S D; D^T 0]. Small or densely connected
/// systems are factorised as dense matrices, long drives as sparse ones with a fill-reducing order that is found once:
/// memory and time are then linear in the drive, whatever the number of constraints.
template <int kDof>
class CameraSolver {
 public:
  using Block = Eigen::Matrix<double, kDof, kDof>;

  /// `pattern`: (row, column) of the blocks on and above the diagonal; the diagonal first, then by row and column. Of
  /// `constraints` only the pattern counts.
  CameraSolver(int columns, const std::vector<std::array<int, 2>>& pattern, const ConstraintMatrix& constraints);

  /// False where S is not positive definite along the constraints, or the constraints depend on one another; the solver
  /// is then not to be used until the next success. `constraints` have the pattern given at the start.
  bool Factorize(const std::vector<Block>& blocks, const ConstraintMatrix& constraints);

  /// [S D; D^T 0] [cameras; multipliers] = [right_hand_side; constraint_side].
  void Solve(const Eigen::VectorXd& right_hand_side, const Eigen::VectorXd& constraint_side, Eigen::VectorXd& cameras,
             Eigen::VectorXd& multipliers) const;

 private:
  void MakeSparsePattern(const std::vector<int>& place, const ConstraintMatrix& constraints);
  bool FactorizeDense(const std::vector<Block>& blocks, const ConstraintMatrix& constraints);
  /// Of the sparse system.
  Eigen::MatrixXd Solved(Eigen::MatrixXd right_hand_side) const;

  using Sparse = Eigen::SparseMatrix<double>;
  int columns_;
  std::vector<std::array<int, 2>> pattern_;
  bool is_dense_;
  bool is_constrained_;
  Eigen::MatrixXd matrix_;
  Eigen::LLT<Eigen::MatrixXd, Eigen::Lower> dense_;
  Eigen::MatrixXd reaction_;                  ///< F^-1 D, where S = F F^T
  Eigen::LDLT<Eigen::MatrixXd> coupling_;     ///< D^T S^-1 D
  std::vector<int> start_;                    ///< of each camera's unknowns in the fill-reducing order
  std::vector<int> constraint_place_;         ///< of each constraint there, after its cameras
  Sparse sparse_matrix_;                      ///< lower triangle, in that order
  std::vector<std::array<int, kDof>> value_;  ///< where a block's share of each matrix column starts in the values
  std::vector<int> constraint_value_;         ///< where each entry of the constraints stands in the values
  Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> unconstrained_;
  Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> constrained_;
};

}  // namespace turnscale
