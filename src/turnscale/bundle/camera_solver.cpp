// SPDX-License-Identifier: MIT
#include "turnscale/bundle/camera_solver.h"

#include <algorithm>
#include <cstddef>

namespace turnscale {
namespace {

/// Up to this size the dense factorisation wins whatever the pattern; beyond it where most blocks are filled.
constexpr int kSmallSystem = 72;
constexpr double kDenseShare = 0.4;

}  // namespace

template <int kDof>
CameraSolver<kDof>::CameraSolver(int columns, const std::vector<std::array<int, 2>>& pattern)
    : columns_(columns), pattern_(pattern) {
  const double all_blocks = 0.5 * columns * (columns + 1.0);
  is_dense_ = columns * kDof <= kSmallSystem || static_cast<double>(pattern.size()) > kDenseShare * all_blocks;
  if (is_dense_) {
    const Eigen::Index size = Eigen::Index{kDof} * columns;
    matrix_.setZero(size, size);
  } else {
    MakeSparsePattern();
    sparse_.analyzePattern(sparse_matrix_);
  }
}

template <int kDof>
void CameraSolver<kDof>::MakeSparsePattern() {
  // A block (row, column) above the diagonal is stored transposed, below it: its row becomes the sparse columns.
  std::vector<std::vector<int>> blocks_of_row(columns_);
  for (std::size_t i = 0; i < pattern_.size(); ++i) blocks_of_row[pattern_[i][0]].push_back(static_cast<int>(i));
  std::vector<Eigen::Triplet<double>> entries;
  value_.resize(pattern_.size());
  int next = 0;
  for (int row = 0; row < columns_; ++row) {
    for (int k = 0; k < kDof; ++k) {
      for (const int i : blocks_of_row[row]) {
        const int column = pattern_[i][1];
        value_[i][k] = next;
        for (int l = column == row ? k : 0; l < kDof; ++l) {
          entries.emplace_back(column * kDof + l, row * kDof + k, 0.0);
          ++next;
        }
      }
    }
  }
  const Eigen::Index size = Eigen::Index{kDof} * columns_;
  sparse_matrix_.resize(size, size);
  sparse_matrix_.setFromTriplets(entries.begin(), entries.end());
}

template <int kDof>
bool CameraSolver<kDof>::Factorize(const std::vector<Block>& blocks) {
  if (is_dense_) {
    for (std::size_t i = 0; i < pattern_.size(); ++i) {
      matrix_.template block<kDof, kDof>(pattern_[i][1] * kDof, pattern_[i][0] * kDof) = blocks[i].transpose();
    }
    dense_.compute(matrix_);
    return dense_.info() == Eigen::Success && dense_.matrixLLT().diagonal().allFinite();
  }
  double* values = sparse_matrix_.valuePtr();
  for (std::size_t i = 0; i < pattern_.size(); ++i) {
    const bool diagonal = pattern_[i][0] == pattern_[i][1];
    for (int k = 0; k < kDof; ++k) {
      const int first = diagonal ? k : 0;
      for (int l = first; l < kDof; ++l) values[value_[i][k] + l - first] = blocks[i](k, l);
    }
  }
  sparse_.factorize(sparse_matrix_);
  return sparse_.info() == Eigen::Success;
}

template <int kDof>
Eigen::MatrixXd CameraSolver<kDof>::Solve(const Eigen::MatrixXd& right_hand_sides) const {
  if (is_dense_) return dense_.solve(right_hand_sides);
  return sparse_.solve(right_hand_sides);
}

template class CameraSolver<3>;
template class CameraSolver<6>;

}  // namespace turnscale
