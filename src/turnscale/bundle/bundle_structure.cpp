// SPDX-License-Identifier: MIT
#include "turnscale/bundle/bundle_structure.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "turnscale/bundle/reprojection.h"

namespace turnscale {
namespace {

void NumberCameras(const BundleProblem& problem, BundleStructure& structure) {
  const int cameras = static_cast<int>(problem.camera_from_world.size());
  structure.column_of_camera.assign(cameras, -1);
  for (int i = 0; i < cameras; ++i) {
    if (problem.camera_is_fixed[i]) continue;
    structure.column_of_camera[i] = static_cast<int>(structure.camera_of_column.size());
    structure.camera_of_column.push_back(i);
  }
}

void SortObservations(const BundleProblem& problem, const BundleState& state, BundleStructure& structure) {
  const std::size_t points = problem.points.size();
  std::vector<char> usable(problem.observations.size());
  structure.first_observation.assign(points + 1, 0);
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& seen = problem.observations[i];
    usable[i] = IsInFront(state.rotations[seen.camera] * (state.points[seen.point] - state.centres[seen.camera]));
    if (usable[i]) {
      ++structure.first_observation[seen.point + 1];
    } else {
      ++structure.behind_camera;
    }
  }
  for (std::size_t i = 0; i < points; ++i) structure.first_observation[i + 1] += structure.first_observation[i];

  structure.observations.resize(structure.first_observation[points]);
  std::vector<int> next(structure.first_observation.begin(), structure.first_observation.end() - 1);
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    if (!usable[i]) continue;
    const BundleObservation& seen = problem.observations[i];
    structure.observations[next[seen.point]++] = {seen.pixel, 1.0 / seen.sigma, seen.camera, -1};
  }
  for (std::size_t i = 0; i < points; ++i) {
    const std::span track(structure.observations.begin() + structure.first_observation[i],
                          structure.observations.begin() + structure.first_observation[i + 1]);
    // Those of a map are sorted, and sorting takes memory.
    if (!std::ranges::is_sorted(track, {}, &SolverObservation::camera))
      std::ranges::stable_sort(track, {}, &SolverObservation::camera);
  }
}

void MakeEdges(BundleStructure& structure) {
  const std::size_t points = structure.first_observation.size() - 1;
  structure.first_edge.assign(points + 1, 0);
  structure.edge_column.reserve(structure.observations.size());
  for (std::size_t i = 0; i < points; ++i) {
    int last_column = -1;
    for (int k = structure.first_observation[i]; k < structure.first_observation[i + 1]; ++k) {
      const int column = structure.column_of_camera[structure.observations[k].camera];
      if (column < 0) continue;
      if (column != last_column) structure.edge_column.push_back(column);
      last_column = column;
      structure.observations[k].edge = static_cast<int>(structure.edge_column.size()) - 1;
    }
    structure.first_edge[i + 1] = static_cast<int>(structure.edge_column.size());
    structure.longest_track = std::max(structure.longest_track, structure.first_edge[i + 1] - structure.first_edge[i]);
  }
}

template <typename Visit>
void ForEachDistance(const BundleProblem& problem, const Visit& visit) {
  for (const DistanceConstraint& held : problem.distances) visit(held);
  for (const MeasuredDistance& measured : problem.measured_distances) visit(measured.between);
}

/// The smaller one first; -1 where that camera is fixed.
std::array<int, 2> ColumnsOf(const BundleStructure& structure, const DistanceConstraint& held) {
  const auto [a, b] = std::minmax(structure.column_of_camera[held.camera_a], structure.column_of_camera[held.camera_b]);
  return {a, b};
}

/// Block numbers of the upper triangle, row by row up to the last column the row reaches. Keyframes that see the same
/// points are near each other in time, so the rows are short.
class BlockTable {
 public:
  BlockTable(const BundleProblem& problem, const BundleStructure& structure) {
    const int columns = static_cast<int>(structure.camera_of_column.size());
    std::vector<int> reach(columns);
    for (int i = 0; i < columns; ++i) reach[i] = i;
    for (std::size_t i = 0; i + 1 < structure.first_edge.size(); ++i) {
      for (int k = structure.first_edge[i]; k < structure.first_edge[i + 1]; ++k) {
        int& row_reach = reach[structure.edge_column[k]];
        row_reach = std::max(row_reach, structure.edge_column[structure.first_edge[i + 1] - 1]);
      }
    }
    ForEachDistance(problem, [&](const DistanceConstraint& held) {
      const auto [a, b] = ColumnsOf(structure, held);
      if (a >= 0) reach[a] = std::max(reach[a], b);
    });
    row_begin_.assign(columns + 1, 0);
    for (int i = 0; i < columns; ++i) row_begin_[i + 1] = row_begin_[i] + (reach[i] - i + 1);
    block_.assign(row_begin_[columns], -1);
  }

  int& at(int row, int column) { return block_[row_begin_[row] + (column - row)]; }
  int columns() const { return static_cast<int>(row_begin_.size()) - 1; }
  int reach(int row) const { return row + static_cast<int>(row_begin_[row + 1] - row_begin_[row]) - 1; }

 private:
  std::vector<std::size_t> row_begin_;
  std::vector<int> block_;
};

template <typename Visit>
void ForEachPair(const BundleStructure& structure, const Visit& visit) {
  for (std::size_t i = 0; i + 1 < structure.first_edge.size(); ++i) {
    for (int a = structure.first_edge[i]; a < structure.first_edge[i + 1]; ++a) {
      for (int b = a; b < structure.first_edge[i + 1]; ++b) {
        visit(structure.edge_column[a], structure.edge_column[b]);
      }
    }
  }
}

/// Marks a block that is needed but has no number yet.
constexpr int kWanted = 0;

void MakeBlocks(const BundleProblem& problem, BundleStructure& structure) {
  BlockTable table(problem, structure);
  std::size_t pairs = 0;
  ForEachPair(structure, [&](int row, int column) {
    table.at(row, column) = kWanted;
    ++pairs;
  });
  ForEachDistance(problem, [&](const DistanceConstraint& held) {
    const auto [a, b] = ColumnsOf(structure, held);
    if (a >= 0) table.at(a, b) = kWanted;
  });
  for (int i = 0; i < table.columns(); ++i) {
    table.at(i, i) = i;
    structure.blocks.push_back({i, i});
  }
  for (int row = 0; row < table.columns(); ++row) {
    for (int column = row + 1; column <= table.reach(row); ++column) {
      if (table.at(row, column) != kWanted) continue;
      table.at(row, column) = static_cast<int>(structure.blocks.size());
      structure.blocks.push_back({row, column});
    }
  }
  structure.pair_block.reserve(pairs);
  structure.first_pair.reserve(structure.first_edge.size());
  std::size_t next_pair = 0;
  for (std::size_t i = 0; i + 1 < structure.first_edge.size(); ++i) {
    structure.first_pair.push_back(next_pair);
    const auto edges = static_cast<std::size_t>(structure.first_edge[i + 1] - structure.first_edge[i]);
    next_pair += edges * (edges + 1) / 2;
  }
  structure.first_pair.push_back(next_pair);
  ForEachPair(structure, [&](int row, int column) { structure.pair_block.push_back(table.at(row, column)); });
  const auto block_of = [&](const DistanceConstraint& held) {
    const auto [a, b] = ColumnsOf(structure, held);
    return a >= 0 ? table.at(a, b) : -1;
  };
  for (const DistanceConstraint& held : problem.distances) structure.distance_block.push_back(block_of(held));
  for (const MeasuredDistance& measured : problem.measured_distances)
    structure.measured_distance_block.push_back(block_of(measured.between));
}

}  // namespace

BundleStructure MakeStructure(const BundleProblem& problem, const BundleState& state) {
  BundleStructure structure;
  NumberCameras(problem, structure);
  SortObservations(problem, state, structure);
  MakeEdges(structure);
  MakeBlocks(problem, structure);
  return structure;
}

}  // namespace turnscale
