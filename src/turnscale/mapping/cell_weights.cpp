// SPDX-License-Identifier: MIT
#include "turnscale/mapping/cell_weights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace turnscale {

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

}  // namespace turnscale
