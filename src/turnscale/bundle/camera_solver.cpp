// SPDX-License-Identifier: MIT
#include "turnscale/bundle/camera_solver.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace turnscale {
namespace {

/// Up to this size the dense factorisation wins whatever the pattern; beyond it where most blocks are filled.
constexpr int kSmallSystem = 72;
constexpr double kDenseShare = 0.4;

/// Order of the columns that keeps the factor sparse: found on the blocks, since on single entries it is slower to find
/// and may miss that entries of one block belong together.
std::vector<int> FillReducingOrder(int columns, const std::vector<std::array<int, 2>>& pattern) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [row, column] : pattern) {
    entries.emplace_back(row, column, 1.0);
    if (row != column) entries.emplace_back(column, row, 1.0);
  }
  Eigen::SparseMatrix<double> graph(columns, columns);
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(graph, order);
  std::vector<int> place(columns);
  for (int i = 0; i < columns; ++i) place[order.indices()[i]] = i;
  return place;
}

}  // namespace

template <int kDof>
CameraSolver<kDof>::CameraSolver(int columns, const std::vector<std::array<int, 2>>& pattern,
                                 const ConstraintMatrix& constraints)
    : columns_(columns), pattern_(pattern), is_constrained_(constraints.cols() > 0) {
  const double all_blocks = 0.5 * columns * (columns + 1.0);
  is_dense_ = columns * kDof <= kSmallSystem || static_cast<double>(pattern.size()) > kDenseShare * all_blocks;
  if (is_dense_) {
    const Eigen::Index size = Eigen::Index{kDof} * columns;
    matrix_.setZero(size, size);
    return;
  }
  MakeSparsePattern(FillReducingOrder(columns, pattern), constraints);
  if (is_constrained_) {
    constrained_.analyzePattern(sparse_matrix_);
  } else {
    unconstrained_.analyzePattern(sparse_matrix_);
  }
}

template <int kDof>
void CameraSolver<kDof>::MakeSparsePattern(const std::vector<int>& place, const ConstraintMatrix& constraints) {
  // A constraint has a pivot once its cameras are eliminated. Right after them it fills in no more than the second one.
  std::vector<int> camera_at(columns_);
  for (int i = 0; i < columns_; ++i) camera_at[place[i]] = i;
  std::vector<std::vector<int>> constraints_after(columns_);
  for (int i = 0; i < constraints.cols(); ++i) {
    int last = 0;
    for (ConstraintMatrix::InnerIterator entry(constraints, i); entry; ++entry)
      last = std::max(last, place[entry.row() / kDof]);
    constraints_after[last].push_back(i);
  }
  start_.resize(columns_);
  constraint_place_.resize(constraints.cols());
  int size = 0;
  for (int i = 0; i < columns_; ++i) {
    start_[camera_at[i]] = size;
    size += kDof;
    for (const int constraint : constraints_after[i]) constraint_place_[constraint] = size++;
  }

  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [row, column] : pattern_) {
    const auto [first, second] = std::minmax(start_[row], start_[column]);
    for (int k = 0; k < kDof; ++k)
      for (int l = second == first ? k : 0; l < kDof; ++l) entries.emplace_back(second + l, first + k, 0.0);
  }
  const auto unknown = [&](const ConstraintMatrix::InnerIterator& entry) {
    return start_[entry.row() / kDof] + static_cast<int>(entry.row() % kDof);
  };
  for (int i = 0; i < constraints.cols(); ++i) {
    entries.emplace_back(constraint_place_[i], constraint_place_[i], 0.0);
    for (ConstraintMatrix::InnerIterator entry(constraints, i); entry; ++entry)
      entries.emplace_back(constraint_place_[i], unknown(entry), 0.0);
  }
  sparse_matrix_.resize(size, size);
  sparse_matrix_.setFromTriplets(entries.begin(), entries.end());

  const int* rows = sparse_matrix_.innerIndexPtr();
  const auto position = [&](int row, int column) {
    const int* begin = sparse_matrix_.outerIndexPtr() + column;
    return static_cast<int>(std::lower_bound(rows + begin[0], rows + begin[1], row) - rows);
  };
  value_.resize(pattern_.size());
  for (std::size_t i = 0; i < pattern_.size(); ++i) {
    const auto [first, second] = std::minmax(start_[pattern_[i][0]], start_[pattern_[i][1]]);
    for (int k = 0; k < kDof; ++k) value_[i][k] = position(second == first ? second + k : second, first + k);
  }
  for (int i = 0; i < constraints.cols(); ++i)
    for (ConstraintMatrix::InnerIterator entry(constraints, i); entry; ++entry)
      constraint_value_.push_back(position(constraint_place_[i], unknown(entry)));
}

template <int kDof>
bool CameraSolver<kDof>::FactorizeDense(const std::vector<Block>& blocks, const ConstraintMatrix& constraints) {
  for (std::size_t i = 0; i < pattern_.size(); ++i) {
    matrix_.template block<kDof, kDof>(pattern_[i][1] * kDof, pattern_[i][0] * kDof) = blocks[i].transpose();
  }
  dense_.compute(matrix_);
  if (dense_.info() != Eigen::Success || !dense_.matrixLLT().diagonal().allFinite()) return false;
  if (!is_constrained_) return true;
  reaction_ = dense_.matrixL().solve(Eigen::MatrixXd(constraints));
  coupling_.compute(reaction_.transpose() * reaction_);
  return coupling_.info() == Eigen::Success && (coupling_.vectorD().array() > 0).all();
}

template <int kDof>
bool CameraSolver<kDof>::Factorize(const std::vector<Block>& blocks, const ConstraintMatrix& constraints) {
  if (is_dense_) return FactorizeDense(blocks, constraints);
  double* values = sparse_matrix_.valuePtr();
  for (std::size_t i = 0; i < pattern_.size(); ++i) {
    const auto [row, column] = pattern_[i];
    const bool turned = start_[row] > start_[column];
    for (int k = 0; k < kDof; ++k) {
      const int first = row == column ? k : 0;
      for (int l = first; l < kDof; ++l) values[value_[i][k] + l - first] = turned ? blocks[i](l, k) : blocks[i](k, l);
    }
  }
  if (!is_constrained_) {
    unconstrained_.factorize(sparse_matrix_);
    return unconstrained_.info() == Eigen::Success;
  }
  for (std::size_t i = 0; i < constraint_value_.size(); ++i) values[constraint_value_[i]] = constraints.valuePtr()[i];
  constrained_.factorize(sparse_matrix_);
  if (constrained_.info() != Eigen::Success) return false;
  // As many negative pivots as constraints: those of the constraints.
  Eigen::VectorXd pivots = constrained_.vectorD();
  for (const int place : constraint_place_) pivots[place] = -pivots[place];
  return (pivots.array() > 0).all() && pivots.allFinite();
}

template <int kDof>
Eigen::MatrixXd CameraSolver<kDof>::Solved(Eigen::MatrixXd right_hand_side) const {
  if (is_constrained_) return constrained_.solve(right_hand_side);
  unconstrained_.matrixL().solveInPlace(right_hand_side);
  unconstrained_.matrixU().solveInPlace(right_hand_side);
  return right_hand_side;
}

template <int kDof>
void CameraSolver<kDof>::Solve(const Eigen::VectorXd& right_hand_side, const Eigen::VectorXd& constraint_side,
                               Eigen::VectorXd& cameras, Eigen::VectorXd& multipliers) const {
  multipliers.resize(constraint_side.size());
  if (is_dense_) {
    // As matrices: of those, Eigen solves triangular systems in blocks.
    Eigen::MatrixXd half_solved = dense_.matrixL().solve(Eigen::MatrixXd(right_hand_side));
    if (is_constrained_) {
      multipliers = coupling_.solve(reaction_.transpose() * half_solved.col(0) - constraint_side);
      half_solved.col(0) -= reaction_ * multipliers;
    }
    half_solved = dense_.matrixU().solve(half_solved).eval();
    cameras = half_solved.col(0);
    return;
  }
  Eigen::VectorXd placed(sparse_matrix_.rows());
  for (int i = 0; i < columns_; ++i)
    placed.template segment<kDof>(start_[i]) = right_hand_side.template segment<kDof>(kDof * i);
  for (std::size_t i = 0; i < constraint_place_.size(); ++i)
    placed[constraint_place_[i]] = constraint_side[static_cast<Eigen::Index>(i)];
  placed = Solved(std::move(placed));
  cameras.resize(right_hand_side.size());
  for (int i = 0; i < columns_; ++i)
    cameras.template segment<kDof>(kDof * i) = placed.template segment<kDof>(start_[i]);
  for (std::size_t i = 0; i < constraint_place_.size(); ++i)
    multipliers[static_cast<Eigen::Index>(i)] = placed[constraint_place_[i]];
}

template class CameraSolver<3>;
template class CameraSolver<6>;

}  // namespace turnscale
