// SPDX-License-Identifier: MIT
#include "turnscale/rendering/pattern.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include <Eigen/Core>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// Waves longer than a quarter of the side are no stronger than these: they would show where the pattern repeats.
constexpr double kLowestFrequency = 4;

// What waves of so many turns down and across the side are multiplied by: the other half of them are these mirrored.
cv::Mat Gains(int side, double roughness) {
  cv::Mat gains(side / 2 + 1, side / 2 + 1, CV_32F);
  for (int down = 0; down < gains.rows; ++down) {
    for (int across = 0; across <= down; ++across) {
      const double frequency = std::hypot(down, across);
      const double gain = down == 0 ? 0 : std::pow(std::max(frequency, kLowestFrequency), -roughness);
      gains.at<float>(down, across) = gains.at<float>(across, down) = static_cast<float>(gain);
    }
  }
  return gains;
}

// Throws InternalError where the side is not a power of two of at least 16.
void CheckSide(const PatternOptions& options) {
  if (options.side < 16 || !std::has_single_bit(static_cast<unsigned>(options.side)))
    throw InternalError("the side of a pattern is a power of two, 16 or more");
}

// Noise of all sizes (see CloudPattern), mean 0 and standard deviation 1.
cv::Mat Clouds(int side, std::uint64_t seed, double roughness) {
  cv::Mat noise(side, side, CV_32F);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) noise.at<float>(row, column) = HashUniform(seed, row, column) - 0.5F;
  cv::Mat spectrum;
  cv::dft(noise, spectrum, cv::DFT_COMPLEX_OUTPUT);
  const cv::Mat gains = Gains(side, roughness);
  for (int row = 0; row < side; ++row) {
    const auto* gain = gains.ptr<float>(std::min(row, side - row));
    auto* wave = spectrum.ptr<cv::Vec2f>(row);
    for (int column = 0; column < side; ++column) wave[column] *= gain[std::min(column, side - column)];
  }
  cv::Mat clouds;
  cv::dft(spectrum, clouds, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(clouds, mean, deviation);
  return (clouds - mean[0]) / deviation[0];
}

// Shifts and stretches a pattern to the mean and contrast that are asked for, and keeps it within what surfaces
// reflect.
void Finish(const PatternOptions& options, cv::Mat& pattern) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(pattern, mean, deviation);
  const double gain = options.contrast / std::max(deviation[0], 1e-9);
  pattern.convertTo(pattern, CV_32F, gain, options.mean - gain * mean[0]);
  cv::max(pattern, 0.02 * options.mean, pattern);
  cv::min(pattern, options.mean + 5.0 * options.contrast, pattern);
}

// Calls `paint` (value of a pixel, and its place from the centre) for every pixel within `reach` of a centre, around
// the edges of the pattern.
template <typename Paint>
void PaintAround(const Eigen::Vector2f& centre, float reach, const Paint& paint, cv::Mat& pattern) {
  const int mask = pattern.rows - 1;
  const int top = static_cast<int>(std::floor(centre.y() - reach));
  const int left = static_cast<int>(std::floor(centre.x() - reach));
  const int bottom = static_cast<int>(std::ceil(centre.y() + reach));
  const int right = static_cast<int>(std::ceil(centre.x() + reach));
  for (int row = top; row <= bottom; ++row) {
    auto* pixels = pattern.ptr<float>(row & mask);
    for (int column = left; column <= right; ++column)
      paint(pixels[column & mask],
            Eigen::Vector2f(static_cast<float>(column) - centre.x(), static_cast<float>(row) - centre.y()));
  }
}

// 0 below `from`, 1 above `to`, smooth between.
float Smooth(float from, float to, float x) {
  const float t = std::min(1.0F, std::max(0.0F, (x - from) / (to - from)));
  return t * t * (3 - 2 * t);
}

// Seeds of the layers of one pattern.
std::uint64_t Layer(const PatternOptions& options, std::uint64_t layer) { return Hash(options.seed * 1000 + layer); }

Eigen::Vector2f AnyPlace(const cv::Mat& pattern, Random& random) {
  const auto side = static_cast<float>(pattern.rows);
  const float x = random.UniformFloat(0, side);
  return {x, random.UniformFloat(0, side)};
}

Eigen::Vector2f Direction(float angle) { return {std::cos(angle), std::sin(angle)}; }

// Pixels of a pattern of 1024 in one of this side.
float Scale(const cv::Mat& pattern) { return static_cast<float>(pattern.rows) / 1024; }

// Round spots with soft rims, bright and dark: pebbles, chewing gum, drops of oil.
void AddSpots(int count, float least, float most, float strength, Random& random, cv::Mat& pattern) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f centre = AnyPlace(pattern, random);
    // Many small ones, few large ones.
    const float t = random.UniformFloat(0, 1);
    const float radius = least + (most - least) * t * t * t;
    const float value = strength * random.UniformFloat(-1, 1);
    const float stretch = random.UniformFloat(0.6F, 1);
    const Eigen::Vector2f axis = Direction(random.UniformFloat(0, std::numbers::pi_v<float>));
    const auto paint = [&](float& pixel, const Eigen::Vector2f& at) {
      const float along = at.dot(axis);
      const float across = (at.x() * axis.y() - at.y() * axis.x()) / stretch;
      const float distance = std::sqrt(along * along + across * across);
      pixel += value * (1 - Smooth(radius - 0.35F * radius - 0.5F, radius + 0.5F, distance));
    };
    PaintAround(centre, radius + 1.5F, paint, pattern);
  }
}

// A crack: a line that wanders, and now and then splits.
void AddCrack(Eigen::Vector2f at, float angle, int steps, float width, Random& random, cv::Mat& pattern) {
  const float main_angle = angle;
  for (int i = 0; i < steps; ++i) {
    // Wanders around one direction, so that it does not curl.
    angle += random.UniformFloat(-0.5F, 0.5F) + 0.06F * (main_angle - angle);
    at += Direction(angle);
    const float half = width * random.UniformFloat(0.6F, 1.1F);
    const auto paint = [&](float& pixel, const Eigen::Vector2f& from) {
      pixel = std::min(pixel, pixel + 0.9F * (Smooth(half * 0.5F, half + 0.7F, from.norm()) - 1));
    };
    PaintAround(at, half + 1, paint, pattern);
    if (width > 0.8F && random.Uniform() < 0.004F)
      AddCrack(at, angle + random.UniformFloat(-1.2F, 1.2F), steps / 3, width * 0.7F, random, pattern);
  }
}

// A rectangle that was opened and closed again: another shade, a seam of tar around it.
void AddPatch(Random& random, cv::Mat& pattern) {
  const float scale = Scale(pattern);
  const Eigen::Vector2f centre = AnyPlace(pattern, random);
  const float half_height = scale * random.UniformFloat(30, 110);
  const Eigen::Vector2f half(scale * random.UniformFloat(40, 150), half_height);
  const float askew = random.UniformFloat(-0.1F, 0.1F);
  const Eigen::Vector2f axis = Direction(askew + (random.Uniform() < 0.5F ? 0 : 1.5708F));
  const float shade = random.UniformFloat(-0.9F, 0.9F);
  const auto paint = [&](float& pixel, const Eigen::Vector2f& at) {
    const float x = std::abs(at.dot(axis)) - half.x();
    const float y = std::abs(at.x() * axis.y() - at.y() * axis.x()) - half.y();
    const float outside = std::max(x, y);
    pixel += shade * (1 - Smooth(-0.5F, 0.5F, outside));
    pixel -= 1.1F * (1 - Smooth(0.5F, 2, std::abs(outside)));
  };
  PaintAround(centre, half.norm() + 3, paint, pattern);
}

// Blades and leaves, the later ones on top.
void AddLeaves(int count, float length, float depth, Random& random, cv::Mat& pattern) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f centre = AnyPlace(pattern, random);
    const float half = length * random.UniformFloat(0.5F, 1.0F);
    const float width = half * random.UniformFloat(0.35F, 0.6F);
    const Eigen::Vector2f axis = Direction(random.UniformFloat(0, 2 * std::numbers::pi_v<float>));
    const float shade = depth + random.UniformFloat(-0.9F, 0.9F);
    const float tilt = random.UniformFloat(-0.6F, 0.6F);
    const auto paint = [&](float& pixel, const Eigen::Vector2f& at) {
      const float along = at.dot(axis) / half;
      const float across = (at.x() * axis.y() - at.y() * axis.x()) / width;
      const float outside = along * along + std::abs(across) - 1;
      if (outside > 0) return;
      // Halves to both sides of the rib catch the light differently.
      const float rib = across > 0 ? 0.25F : -0.25F;
      pixel = shade + tilt * along + rib - 0.7F * Smooth(-0.25F, 0, outside);
    };
    PaintAround(centre, half + 1, paint, pattern);
  }
}

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

cv::Mat CloudPattern(const PatternOptions& options, double roughness) {
  CheckSide(options);
  cv::Mat pattern = Clouds(options.side, Layer(options, 1), roughness);
  Finish(options, pattern);
  return pattern;
}

cv::Mat PavementPattern(const PatternOptions& options) {
  CheckSide(options);
  cv::Mat pattern = 0.45 * Clouds(options.side, Layer(options, 1), 1.1);
  Random random(Layer(options, 2));
  const float scale = Scale(pattern);
  const int area = options.side * options.side;
  for (int i = 0; i < 7; ++i) AddPatch(random, pattern);
  AddSpots(60, 20 * scale, 70 * scale, 0.7F, random, pattern);
  AddSpots(500, 4 * scale, 18 * scale, 1.1F, random, pattern);
  AddSpots(area / 40, 0.6F, 3.5F, 0.9F, random, pattern);
  for (int i = 0; i < 7; ++i) {
    const Eigen::Vector2f start = AnyPlace(pattern, random);
    const float angle = random.UniformFloat(0, 2 * std::numbers::pi_v<float>);
    const float width = random.UniformFloat(0.8F, 2.0F);
    AddCrack(start, angle, static_cast<int>(scale * random.UniformFloat(150, 700)), width, random, pattern);
  }
  Finish(options, pattern);
  return pattern;
}

cv::Mat FoliagePattern(const PatternOptions& options) {
  CheckSide(options);
  cv::Mat pattern = 0.5 * Clouds(options.side, Layer(options, 1), 1.3) - 1.6;
  Random random(Layer(options, 2));
  const float scale = Scale(pattern);
  // Deep leaves in the shade first, then those in the light; clumps of leaves light and dark over all.
  AddLeaves(2600, 30 * scale, -0.9F, random, pattern);
  AddLeaves(3500, 26 * scale, -0.1F, random, pattern);
  AddLeaves(2600, 22 * scale, 0.6F, random, pattern);
  AddLeaves(1800, 14 * scale, 0.9F, random, pattern);
  pattern += 0.55 * Clouds(options.side, Layer(options, 3), 1.6);
  Finish(options, pattern);
  return pattern;
}

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
