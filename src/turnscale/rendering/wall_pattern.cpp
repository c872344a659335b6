// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/rendering/pattern.h"
#include "turnscale/rendering/pattern_drawing.h"

namespace turnscale {
namespace {

// A brick is so many times as long as high, nearly: a whole number of bricks makes the row.
constexpr float kBrickLength = 2.7F;

struct Window {
  float left = 0.24F;  // parts of the window's cell, from its left and top
  float right = 0.76F;
  float top = 0.2F;
  float bottom = 0.78F;
};

// Whole places of a coordinate that runs 0...count around the pattern, and the place within.
struct Cell {
  int index = 0;
  float within = 0;  // 0...1
};

Cell CellOf(float at, int count) {
  const float whole = std::floor(at);
  return {((static_cast<int>(whole) % count) + count) % count, at - whole};
}

// One pixel of a window and the wall around it, x and y from 0 to 1 over the cell, in units of the contrast.
float WindowPixel(const Window& window, std::uint64_t house, const Cell& column, const Cell& row, float pixel) {
  const float x = column.within;
  const float y = row.within;
  const auto number = static_cast<std::uint64_t>(row.index) * 1000 + static_cast<std::uint64_t>(column.index);
  const float outside = std::max({window.left - x, x - window.right, window.top - y, y - window.bottom});
  const float across = (x - window.left) / (window.right - window.left);
  const float down = (y - window.top) / (window.bottom - window.top);
  const auto edge = [&](float distance) { return 1 - Smooth(-0.5F * pixel, 0.5F * pixel, distance); };

  float value = 0.55F;
  // A ledge between the floors, its shadow below.
  value += 0.5F * edge(std::abs(y - 0.965F) - 0.012F) - 0.9F * edge(std::abs(y - 0.99F) - 0.008F);
  // The sill sticks out and throws a shadow.
  const float beside = std::max(window.left - 0.03F - x, x - window.right - 0.03F);
  value += (1.1F - value) * edge(std::max(beside, std::abs(y - window.bottom - 0.035F) - 0.015F));
  value += (-0.8F - value) * edge(std::max(beside, std::abs(y - window.bottom - 0.065F) - 0.013F));
  // The wall's opening: a bright surround, the frame, a bar, the pane.
  value += (0.95F - value) * edge(outside - 0.03F);
  value += (0.1F - value) * edge(outside);
  value += (1.5F - value) * edge(outside + 0.012F);
  const float bars = std::min(std::abs(across - 0.5F) * (window.right - window.left),
                              std::abs(down - 0.3F) * (window.bottom - window.top));
  const float pane = std::max(outside + 0.035F, 0.012F - bars);
  // Panes mirror the sky, each a little differently; curtains and blinds behind some.
  float glass = -1.9F + 1.2F * HashUniform(house, number, 1) * (1 - down) + 0.5F * (across - 0.5F);
  const float kind = HashUniform(house, number, 2);
  const float curtain = 0.12F + 0.2F * HashUniform(house, number, 3);
  if (kind < 0.45F && std::min(across, 1 - across) < curtain) glass += 1.1F + 0.35F * std::sin(90 * across);
  if (kind > 0.6F && down < HashUniform(house, number, 4)) glass = 0.6F + 0.5F * std::sin(70 * down);
  value += (glass - value) * edge(pane);
  return value;
}

}  // namespace

cv::Mat BrickPattern(const PatternOptions& options, int rows) {
  CheckSide(options);
  if (rows < 1 || rows > options.side / 4) throw InternalError("a pattern has no room for so many rows of bricks");
  const std::uint64_t seed = Hash(options.seed);
  const int columns = std::max(1, static_cast<int>(std::lround(static_cast<float>(rows) / kBrickLength)));
  const cv::Mat fine = Clouds(options.side, Hash(seed + 1), 0.9);
  const cv::Mat bend = Clouds(options.side, Hash(seed + 2), 1.2);
  const cv::Mat weather = Clouds(options.side, Hash(seed + 3), 1.5);
  const auto side = static_cast<float>(options.side);
  const float height = side / static_cast<float>(rows);
  const float length = side / static_cast<float>(columns);
  cv::Mat pattern(options.side, options.side, CV_32F);
  for (int y = 0; y < options.side; ++y) {
    for (int x = 0; x < options.side; ++x) {
      // Edges are not quite straight.
      const float wobble = 0.02F * height * bend.at<float>(y, x);
      const Cell row = CellOf((static_cast<float>(y) + wobble) / height, rows);
      const float bond = row.index % 2 == 0 ? 0.0F : 0.5F;
      const Cell column = CellOf((static_cast<float>(x) + wobble) / length + bond, columns);
      const auto brick = static_cast<std::uint64_t>(row.index) * 10000 + static_cast<std::uint64_t>(column.index);
      const float inside =
          std::min(std::min(row.within, 1 - row.within) * height, std::min(column.within, 1 - column.within) * length);
      const float shade =
          2.4F * (HashUniform(seed, brick) - 0.5F) + 0.8F * (HashUniform(seed, brick, 1) - 0.5F) * column.within;
      const float joint = 1 - Smooth(0.05F * height, 0.05F * height + 1.2F, inside);
      const float shadow = row.within < 0.2F ? 0.3F : 0.0F;
      const float surface = shade + 0.55F * fine.at<float>(y, x) - shadow;
      pattern.at<float>(y, x) =
          surface + joint * (1.7F + 0.3F * fine.at<float>(y, x) - surface) + 0.3F * weather.at<float>(y, x);
    }
  }
  Finish(options, pattern);
  return pattern;
}

cv::Mat FacadePattern(const PatternOptions& options, int floors, int columns) {
  CheckSide(options);
  if (floors < 1 || columns < 1 || std::max(floors, columns) > options.side / 16)
    throw InternalError("a pattern has no room for so many windows");
  const std::uint64_t house = Hash(options.seed);
  Window window;
  window.left += 0.06F * (HashUniform(house, 11) - 0.5F);
  window.right = 1 - window.left;
  window.top += 0.1F * (HashUniform(house, 12) - 0.5F);
  const cv::Mat plaster = Clouds(options.side, Hash(house + 1), 0.9);
  const cv::Mat weather = Clouds(options.side, Hash(house + 2), 1.5);
  const float per_pixel_x = static_cast<float>(columns) / static_cast<float>(options.side);
  const float per_pixel_y = static_cast<float>(floors) / static_cast<float>(options.side);
  cv::Mat pattern(options.side, options.side, CV_32F);
  for (int y = 0; y < options.side; ++y) {
    for (int x = 0; x < options.side; ++x) {
      const Cell column = CellOf((static_cast<float>(x) + 0.5F) * per_pixel_x, columns);
      const Cell row = CellOf((static_cast<float>(y) + 0.5F) * per_pixel_y, floors);
      const float value = WindowPixel(window, house, column, row, 1.5F * std::max(per_pixel_x, per_pixel_y));
      const float dirt = value > 0 ? 1.0F : 0.4F;
      pattern.at<float>(y, x) = value + dirt * (0.16F * plaster.at<float>(y, x) + 0.22F * weather.at<float>(y, x));
    }
  }
  Finish(options, pattern);
  return pattern;
}

}  // namespace turnscale
