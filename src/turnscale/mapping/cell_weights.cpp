// SPDX-License-Identifier: MIT
#include "turnscale/mapping/cell_weights.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

using Cell = std::pair<long, long>;

Cell CellOf(const Pinhole& pinhole, const Eigen::Vector2d& pixel) {
  constexpr double kCellsPerFocalLength = 8;
  const double size = pinhole.fx / kCellsPerFocalLength;
  return {std::lround(pixel.x() / size), std::lround(pixel.y() / size)};
}

// Numbers of pixels in a cell.
struct Content {
  int all = 0;
  int counted = 0;
  int of_rows = 0;
};

}  // namespace

std::vector<double> CellWeights(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels, double most) {
  std::vector<Cell> cells;
  cells.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) cells.push_back(CellOf(pinhole, pixel));
  std::map<Cell, int> counts;
  for (const Cell& each : cells) ++counts[each];
  std::vector<double> weights;
  weights.reserve(pixels.size());
  for (const Cell& each : cells) weights.push_back(std::min(1.0, most / counts[each]));
  return weights;
}

double ShareOfCells(const Pinhole& pinhole, const std::vector<Eigen::Vector2d>& pixels,
                    const std::vector<char>& is_counted, const std::vector<char>& is_of_rows) {
  constexpr double kEdge = 0.1;
  std::map<Cell, Content> cells;
  for (size_t i = 0; i < pixels.size(); ++i) {
    Content& content = cells[CellOf(pinhole, pixels[i])];
    ++content.all;
    content.counted += is_counted[i] != 0 ? 1 : 0;
    content.of_rows += is_of_rows[i] != 0 ? 1 : 0;
  }
  std::vector<double> rows;
  for (const auto& [cell, content] : cells)
    if (2 * content.of_rows > content.all) rows.push_back(static_cast<double>(cell.second));
  if (rows.empty()) return 0;
  const double top = Quantile(rows, kEdge);
  const double bottom = Quantile(rows, 1 - kEdge);
  int all = 0;
  int counted = 0;
  for (const auto& [cell, content] : cells) {
    const auto row = static_cast<double>(cell.second);
    if (row < top || row > bottom) continue;
    ++all;
    counted += 2 * content.counted > content.all ? 1 : 0;
  }
  return static_cast<double>(counted) / all;
}

}  // namespace turnscale
