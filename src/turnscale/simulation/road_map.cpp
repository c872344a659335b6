// SPDX-License-Identifier: MIT
#include "turnscale/simulation/road_map.h"

#include <algorithm>
#include <cmath>

namespace turnscale {
namespace {

// Heights of roads that pass nearby blend over about this distance, metres.
constexpr double kBlend = 7;
// A cell that no road reaches takes a little of the mean height.
constexpr double kMeanWeight = 1e-6;

}  // namespace

RoadMap::RoadMap(const std::vector<std::vector<RoadPoint>>& roads, const std::vector<RoadPoint>& driven,
                 double margin) {
  Eigen::Vector2d high = driven.front().place;
  low_ = high;
  const auto include = [&](const RoadPoint& point) {
    low_ = low_.cwiseMin(point.place);
    high = high.cwiseMax(point.place);
  };
  for (const RoadPoint& point : driven) include(point);
  for (const std::vector<RoadPoint>& road : roads)
    for (const RoadPoint& point : road) include(point);
  low_ -= Eigen::Vector2d::Constant(margin);
  high += Eigen::Vector2d::Constant(margin);
  columns_ = static_cast<int>((high.x() - low_.x()) / kCell) + 2;
  rows_ = static_cast<int>((high.y() - low_.y()) / kCell) + 2;

  const size_t cells = static_cast<size_t>(columns_) * rows_;
  to_road_.assign(cells, kFar);
  to_driven_.assign(cells, kFar);
  for (const std::vector<RoadPoint>& road : roads) Nearest(road, to_road_);
  Nearest(driven, to_driven_);
  Heights(roads);
}

Eigen::Vector2d RoadMap::high() const { return low_ + kCell * Eigen::Vector2d(columns_ - 1, rows_ - 1); }

double RoadMap::Interpolated(const Grid& grid, const Eigen::Vector2d& place) const {
  const double x = std::clamp((place.x() - low_.x()) / kCell, 0.0, columns_ - 1.001);
  const double z = std::clamp((place.y() - low_.y()) / kCell, 0.0, rows_ - 1.001);
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(z);
  const double* at = &grid[static_cast<size_t>(row) * columns_ + column];
  const double right = x - column;
  const double ahead = z - row;
  return (1 - ahead) * ((1 - right) * at[0] + right * at[1]) +
         ahead * ((1 - right) * at[columns_] + right * at[columns_ + 1]);
}

void RoadMap::Nearest(const std::vector<RoadPoint>& points, Grid& distance) const {
  const int reach = static_cast<int>(kFar / kCell);
  for (const RoadPoint& point : points) {
    const Eigen::Vector2d at = (point.place - low_) / kCell;
    const int column = static_cast<int>(at.x());
    const int row = static_cast<int>(at.y());
    for (int r = std::max(0, row - reach); r <= std::min(rows_ - 1, row + reach); ++r)
      for (int c = std::max(0, column - reach); c <= std::min(columns_ - 1, column + reach); ++c) {
        double& nearest = distance[static_cast<size_t>(r) * columns_ + c];
        nearest = std::min(nearest, kCell * std::hypot(c - at.x(), r - at.y()));
      }
  }
}

void RoadMap::Heights(const std::vector<std::vector<RoadPoint>>& roads) {
  double mean = 0;
  double count = 0;
  for (const std::vector<RoadPoint>& road : roads)
    for (const RoadPoint& point : road) {
      mean += point.up;
      ++count;
    }
  mean /= count;
  Grid weight(to_road_.size(), kMeanWeight);
  up_.assign(to_road_.size(), kMeanWeight * mean);
  const int reach = static_cast<int>(kFar / kCell);
  for (const std::vector<RoadPoint>& road : roads)
    for (const RoadPoint& point : road) {
      const Eigen::Vector2d at = (point.place - low_) / kCell;
      const int column = static_cast<int>(at.x());
      const int row = static_cast<int>(at.y());
      for (int r = std::max(0, row - reach); r <= std::min(rows_ - 1, row + reach); ++r)
        for (int c = std::max(0, column - reach); c <= std::min(columns_ - 1, column + reach); ++c) {
          const double square = kCell * kCell * ((c - at.x()) * (c - at.x()) + (r - at.y()) * (r - at.y()));
          const double near = 1 / (1 + square / (kBlend * kBlend));
          const double w = near * near * near;
          const size_t cell = static_cast<size_t>(r) * columns_ + c;
          weight[cell] += w;
          up_[cell] += w * point.up;
        }
    }
  for (size_t cell = 0; cell < up_.size(); ++cell) up_[cell] /= weight[cell];
}

}  // namespace turnscale
