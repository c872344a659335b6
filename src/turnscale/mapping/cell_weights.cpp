// SPDX-License-Identifier: MIT
#include "turnscale/mapping/cell_weights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace turnscale {
namespace {

// (column, weight) of pixels.
using Columns = std::vector<std::pair<double, double>>;

double Width(Columns columns) {
  constexpr double kEdge = 0.1;
  std::ranges::sort(columns);
  double total = 0;
  for (const auto& [column, weight] : columns) total += weight;
  const auto at = [&](double share) {
    double sum = 0;
    for (const auto& [column, weight] : columns) {
      sum += weight;
      if (sum >= share * total) return column;
    }
    return 0.0;
  };
  return at(1 - kEdge) - at(kEdge);
}

}  // namespace

std::vector<double> CellWeights(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels, double most) {
  constexpr double kCellsPerFocalLength = 8;
  const double size = pinhole.fx / kCellsPerFocalLength;
  std::vector<std::pair<long, long>> cells;
  cells.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels)
    cells.emplace_back(std::lround(pixel.x() / size), std::lround(pixel.y() / size));
  std::map<std::pair<long, long>, int> counts;
  for (const auto& each : cells) ++counts[each];
  std::vector<double> weights;
  weights.reserve(pixels.size());
  for (const auto& each : cells) weights.push_back(std::min(1.0, most / counts[each]));
  return weights;
}

double ShareOfWidth(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels,
                    const std::vector<char>& is_counted) {
  const std::vector<double> weights = CellWeights(pinhole, pixels, 1);
  Columns all;
  Columns counted;
  for (size_t i = 0; i < pixels.size(); ++i) {
    all.emplace_back(pixels[i].x(), weights[i]);
    if (is_counted[i] != 0) counted.push_back(all.back());
  }
  const double width = Width(std::move(all));
  return counted.empty() || !(width > 0) ? 0 : Width(std::move(counted)) / width;
}

}  // namespace turnscale
