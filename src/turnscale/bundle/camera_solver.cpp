// SPDX-License-Identifier: MIT
#include "turnscale/bundle/camera_solver.h"

#include <algorithm>
#include <cstddef>

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
CameraSolver<kDof>::CameraSolver(int columns, const std::vector<std::array<int, 2>>& pattern)
    : columns_(columns), pattern_(pattern) {
  const double all_blocks = 0.5 * columns * (columns + 1.0);
  is_dense_ = columns * kDof <= kSmallSystem || static_cast<double>(pattern.size()) > kDenseShare * all_blocks;
  if (is_dense_) {
    const Eigen::Index size = Eigen::Index{kDof} * columns;
    matrix_.setZero(size, size);
  } else {
    place_ = FillReducingOrder(columns, pattern);
    MakeSparsePattern();
    sparse_.analyzePattern(sparse_matrix_);
  }
}

template <int kDof>
void CameraSolver<kDof>::MakeSparsePattern() {
  // The lower triangle in the new order, column by column: a block stands in the columns of whichever of its two
  // cameras comes first there.
  std::vector<std::vector<int>> blocks_of_place(columns_);
  for (std::size_t i = 0; i < pattern_.size(); ++i) {
    const auto [row, column] = pattern_[i];
    blocks_of_place[std::min(place_[row], place_[column])].push_back(static_cast<int>(i));
  }
  std::vector<Eigen::Triplet<double>> entries;
  value_.resize(pattern_.size());
  int next = 0;
  for (int first = 0; first < columns_; ++first) {
    std::vector<int>& blocks = blocks_of_place[first];
    const auto below = [&](int i) { return std::max(place_[pattern_[i][0]], place_[pattern_[i][1]]); };
    std::ranges::sort(blocks, {}, below);
    for (int k = 0; k < kDof; ++k) {
      for (const int i : blocks) {
        const int second = below(i);
        value_[i][k] = next;
        for (int l = second == first ? k : 0; l < kDof; ++l) {
          entries.emplace_back(second * kDof + l, first * kDof + k, 0.0);
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
    const auto [row, column] = pattern_[i];
    const bool turned = place_[row] > place_[column];
    for (int k = 0; k < kDof; ++k) {
      const int first = row == column ? k : 0;
      for (int l = first; l < kDof; ++l) values[value_[i][k] + l - first] = turned ? blocks[i](l, k) : blocks[i](k, l);
    }
  }
  sparse_.factorize(sparse_matrix_);
  return sparse_.info() == Eigen::Success;
}

template <int kDof>
Eigen::MatrixXd CameraSolver<kDof>::SolveLower(const Eigen::MatrixXd& right_hand_sides) const {
  if (is_dense_) return dense_.matrixL().solve(right_hand_sides);
  Eigen::MatrixXd placed(right_hand_sides.rows(), right_hand_sides.cols());
  for (int i = 0; i < columns_; ++i) {
    placed.template middleRows<kDof>(kDof * place_[i]) = right_hand_sides.template middleRows<kDof>(kDof * i);
  }
  sparse_.matrixL().solveInPlace(placed);
  return placed;
}

template <int kDof>
Eigen::MatrixXd CameraSolver<kDof>::SolveUpper(Eigen::MatrixXd half_solved) const {
  if (is_dense_) return dense_.matrixU().solve(half_solved);
  sparse_.matrixU().solveInPlace(half_solved);
  Eigen::MatrixXd solution(half_solved.rows(), half_solved.cols());
  for (int i = 0; i < columns_; ++i) {
    solution.template middleRows<kDof>(kDof * i) = half_solved.template middleRows<kDof>(kDof * place_[i]);
  }
  return solution;
}

template class CameraSolver<3>;
template class CameraSolver<6>;

}  // namespace turnscale
